// Keeps the page's files, so that it opens without connection. What is pressed then waits in the page.
const KEPT = "muster-phone-1";
const FILES = ["./", "page.css", "page.mjs", "language.mjs", "noise.mjs", "ground.mjs", "places.mjs", "queue.mjs", "map.mjs", "way.mjs", "words.mjs", "fr.mjs", "es.mjs", "zh.mjs",
  "app.webmanifest", "icon.svg"];

self.addEventListener("install", (event) => event.waitUntil(caches.open(KEPT).then((cache) => cache.addAll(FILES)).then(() => self.skipWaiting())));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));

/** The newest, and where there is no connection what was kept. */
async function answer(request) {
  const cache = await caches.open(KEPT);
  try {
    const response = await fetch(request);
    if (response.ok) await cache.put(request, response.clone());
    return response;
  } catch (error) {
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}

self.addEventListener("fetch", (event) => {
  if (event.request.method === "GET") event.respondWith(answer(event.request));
});
