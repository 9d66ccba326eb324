import { background } from "./background.js";
import { baseMap } from "./base_map.js";
import { degrees } from "./degrees.js";
import { grid } from "./grid.js";
import { ground } from "./ground.js";
import { roads } from "./roads.js";
import { water } from "./water.js";

/** The layers of the ground, the lowest first: the map and the scene have them. */
export const BELOW = [ground, water, baseMap, background, roads, grid, degrees];
