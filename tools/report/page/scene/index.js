export { Film } from "./film.js";
export { SceneView } from "./view.js";
