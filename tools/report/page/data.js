import { Run } from "./run.js";

/** A stream of what the page holds packed. */
export function inflate(base64) {
  const text = atob(base64.trim());
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  return new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
}

/** The runs that the page holds. */
export async function embeddedRuns() {
  const scripts = [...document.querySelectorAll('script[type="text/x-muster-run"]')];
  return Promise.all(scripts.map(async (script) => {
    const run = new Run();
    run.apply(await new Response(inflate(script.textContent)).json());
    script.remove();
    return run;
  }));
}

/** Address of the events of a live page; null on a page that holds its runs. */
export function liveAddress() {
  return document.querySelector('script[type="text/x-muster-live"]')?.textContent.trim() ?? null;
}

/** Follows a mission; calls changed(run, isNew) with each chunk, status(text) as the line goes up and down. */
export function follow(address, changed, status) {
  const source = new EventSource(address);
  let run = null;
  source.addEventListener("open", () => status("connected"));
  source.addEventListener("chunk", (event) => {
    const chunk = JSON.parse(event.data);
    const isNew = Boolean(chunk.scenario);
    if (isNew) run = new Run();
    run.apply(chunk);
    changed(run, isNew);
  });
  source.addEventListener("bye", () => {
    source.close();
    status("closed");
  });
  source.addEventListener("error", () => {
    if (source.readyState !== EventSource.CLOSED) status("waiting");
  });
}
