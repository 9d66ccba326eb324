import { BoxBufferGeometry, BufferAttribute, BufferGeometry, CircleBufferGeometry, ConeBufferGeometry,
  CylinderBufferGeometry, OctahedronBufferGeometry, PlaneBufferGeometry, RingBufferGeometry } from "three";

function merged(parts) {
  const flat = parts.map((part) => (part.index ? part.toNonIndexed() : part));
  const geometry = new BufferGeometry();
  for (const name of ["position", "normal"]) {
    const all = flat.flatMap((part) => [...part.attributes[name].array]);
    geometry.setAttribute(name, new BufferAttribute(new Float32Array(all), 3));
  }
  return geometry;
}

function dart() {
  const [nose, left, right, top, below] = [[1.5, 0, 0], [-1.1, 0, -1], [-1.1, 0, 1], [-0.6, 0.5, 0], [-0.6, -0.25, 0]];
  const faces = [nose, top, left, nose, right, top, left, top, right, nose, left, below, nose, below, right, left, right, below];
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(faces.flat()), 3));
  geometry.computeVertexNormals();
  return geometry;
}

const rotor = (x, z) => new CircleBufferGeometry(0.55, 5).rotateX(-Math.PI / 2).translate(x, 0.3, z);
const flat = (shape, y) => shape.rotateX(-Math.PI / 2).translate(0, y, 0);

// Few triangles: without a graphics card, thousands of bodies cost by them.

/** A dart that flies to the east, with four rotors. */
export const uavShape = () => merged([dart(), rotor(0.6, 0.9), rotor(0.6, -0.9), rotor(-1, 1.2), rotor(-1, -1.2)]);

/** Stands on the ground. */
export const workerShape = () => merged([new CylinderBufferGeometry(0.5, 0.75, 1.5, 5, 1, true).translate(0, 0.75, 0),
  new OctahedronBufferGeometry(0.6).translate(0, 1.9, 0)]);

export const vehicleShape = () => merged([new BoxBufferGeometry(2.4, 0.9, 1.4).translate(0, 0.6, 0),
  new BoxBufferGeometry(0.9, 0.7, 1.3).translate(0.5, 1.35, 0)]);

/** What failed: two crossed beams. */
export const failedShape = () => merged([new BoxBufferGeometry(3, 0.6, 0.6).rotateY(Math.PI / 4).translate(0, 0.5, 0),
  new BoxBufferGeometry(3, 0.6, 0.6).rotateY(-Math.PI / 4).translate(0, 0.5, 0)]);

export const taskShape = () => merged([new OctahedronBufferGeometry(1)]);
export const doneShape = () => merged([flat(new CircleBufferGeometry(0.7, 6), 0)]);
/** A pad with a post. */
export const chargingShape = () => merged([flat(new PlaneBufferGeometry(2, 2), 0.05),
  new CylinderBufferGeometry(0.12, 0.3, 2.4, 4, 1, true).translate(0, 1.2, 0), new OctahedronBufferGeometry(0.55).translate(0, 2.6, 0)]);
export const ringShape = () => merged([flat(new RingBufferGeometry(0.84, 1.1, 18), 0)]);
/** One unit high, its point up. */
export const beamShape = () => merged([new ConeBufferGeometry(1, 1, 16, 1, true).translate(0, 0.5, 0)]);
export const columnShape = () => merged([new CylinderBufferGeometry(1, 1, 1, 16, 1, true).translate(0, 0.5, 0)]);
/** One unit long along y, around its middle. */
export const barShape = () => merged([new CylinderBufferGeometry(0.5, 0.5, 1, 6)]);
export const blockShape = () => merged([new BoxBufferGeometry(1, 1, 1).translate(0, 0.5, 0)]);
