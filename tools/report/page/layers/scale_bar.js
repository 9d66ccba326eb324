import { theme } from "../theme.js";

const FONT = "system-ui, sans-serif";
const SCALES = [100000, 50000, 20000, 10000, 5000, 2000, 1000, 500, 200, 100, 50, 20, 10, 5]; // metres, of the bar

/** The longest round distance that fits. */
function scaleOf(perMetre, frame) {
  const room = Math.min(140, Math.max(40, (frame.right - frame.left) / 3));
  const metres = SCALES.find((m) => m * perMetre <= room) ?? SCALES.at(-1);
  return { metres, length: metres * perMetre, right: frame.right - 12, bottom: frame.bottom - 10 };
}

/** Where the scale and the arrow to the north stand: [{ left, top, wide, high }]. */
export function scaleBoxes(perMetre, frame) {
  const { length, right, bottom } = scaleOf(perMetre, frame);
  return [{ left: right - length - 6, top: bottom - 19, wide: length + 12, high: 25 }, { left: right - 22, top: frame.top + 6, wide: 26, high: 36 }];
}

/** How long a distance is, and where north is: inside the frame, at the right. */
function draw(c, { perMetre, frame }) {
  const { metres, length, right, bottom } = scaleOf(perMetre, frame);
  const text = metres >= 1000 ? `${metres / 1000} km` : `${metres} m`;
  c.fillStyle = theme.bg;
  c.globalAlpha = 0.8;
  for (const box of scaleBoxes(perMetre, frame)) c.fillRect(box.left, box.top, box.wide, box.high);
  c.globalAlpha = 1;
  c.strokeStyle = theme.text;
  c.fillStyle = theme.text;
  c.lineWidth = 1.5;
  c.beginPath();
  c.moveTo(right - length, bottom - 4);
  c.lineTo(right - length, bottom);
  c.lineTo(right, bottom);
  c.lineTo(right, bottom - 4);
  c.stroke();
  c.font = `11px ${FONT}`;
  c.textAlign = "center";
  c.fillText(text, right - length / 2, bottom - 6);
  const top = frame.top + 9;
  c.beginPath();
  c.moveTo(right - 9, top);
  c.lineTo(right - 4, top + 15);
  c.lineTo(right - 9, top + 11);
  c.lineTo(right - 14, top + 15);
  c.closePath();
  c.fill();
  c.fillText("N", right - 9, top + 28);
}

export const scaleBar = { draw };
