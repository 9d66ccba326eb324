import { background } from "./background.js";
import { baseMap } from "./base_map.js";
import { degrees } from "./degrees.js";
import { grid } from "./grid.js";
import { ground } from "./ground.js";
import { roads } from "./roads.js";
import { streetNames } from "./street_names.js";
import { water } from "./water.js";

/** Those that look the same wherever the map is moved to, the lowest first. */
export const STILL = [ground, water, baseMap, background, roads];

/** The layers of the ground, the lowest first: the map and the scene have them. */
export const BELOW = [...STILL, grid, degrees, streetNames];
