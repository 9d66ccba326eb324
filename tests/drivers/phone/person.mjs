// A person with a phone, played by Chromium: reads the page, walks where it says, presses its buttons, takes photos. The position
// is made here; all else is what the page shows.
import { distance_m, MissionMap, towards } from "../../../drivers/places.mjs";

const STEP_MS = 200;
const THERE_M = 2;
/** Of the scenario's speed: who wants to be in time is early. */
const PACE = 1.1;
const ACCURACY_M = 6;

/** What the page shows. */
function look(page) {
  return page.evaluate(() => {
    const text = (id) => document.getElementById(id).textContent;
    const geo = document.getElementById("geo");
    const place = geo.hidden ? null : /^geo:([-0-9.]+),([-0-9.]+)/.exec(geo.href);
    return {
      title: text("title"), lines: [...document.getElementById("lines").children].map((line) => line.textContent), act: text("act"),
      canPress: !document.getElementById("act").disabled, notes: [...document.getElementById("notes").children].map((line) => line.textContent),
      to: place && { latitude_deg: Number(place[1]), longitude_deg: Number(place[2]) },
    };
  });
}

/**
 * Takes part until the page, or isOver(), says that it is over. `of`: {browser, link, origin, at (metres), speed_m_s, rate, takesPhotos, note(words),
 * isOver()}.
 * Returns what was pressed, and its photos.
 */
export async function bePerson({ browser, link, origin, at, speed_m_s, rate, takesPhotos = false, note = () => {}, isOver = () => false }) {
  const map = new MissionMap(origin);
  const here = { ...at }, pressed = [], photos = [];
  const position = () => {
    const { latitude_deg, longitude_deg } = map.toDegrees(here);
    return { latitude: latitude_deg, longitude: longitude_deg, accuracy: ACCURACY_M };
  };
  const context = await browser.newContext({ viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true, deviceScaleFactor: 1,
    geolocation: position(), permissions: ["geolocation"] });
  const page = await context.newPage();
  const press = async (seen) => {
    pressed.push(seen.act);
    note(`${seen.title}: ${seen.act}`);
    await page.locator("#act").tap();
  };
  const photograph = async (seen) => {
    const buffer = await page.screenshot();  // a picture like no other
    await page.locator("#photo").setInputFiles({ name: "photo.png", mimeType: "image/png", buffer });
    photos.push({ title: seen.title, bytes: buffer.length });
    note(`${seen.title}: a photo of ${buffer.length} bytes`);
  };
  const walk = async (to, way_m) => {
    const goal = map.toMetres(to), left_m = distance_m(here, goal);
    Object.assign(here, towards(here, goal, way_m));
    if (left_m > 0) await context.setGeolocation(position());
    return left_m <= way_m + THERE_M;
  };
  try {
    await page.goto(link);
    let work = "", last_ms = performance.now();
    for (;;) {
      const seen = await look(page);
      const way_m = (PACE * speed_m_s * rate * (performance.now() - last_ms)) / 1000;
      last_ms = performance.now();
      if (isOver() || seen.title === "The mission is over for you" || seen.title === "You are out of the mission") return { pressed, photos, end: seen };
      if (seen.act === "I am here" && seen.to) {
        if ((await walk(seen.to, way_m)) && seen.canPress) await press(seen);
      } else if (seen.act === "Done" || seen.act === "Battery changed") {
        if (takesPhotos && work !== seen.title) await photograph(seen);
        work = seen.title;
        if (seen.canPress && seen.lines.some((line) => /, (late by|in 0 s)/.test(line))) await press(seen);
      } else {
        work = "";
      }
      await new Promise((resolve) => setTimeout(resolve, STEP_MS));
    }
  } finally {
    await context.close();
  }
}
