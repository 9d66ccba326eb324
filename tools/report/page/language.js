/**
 * The page's language. Everything that the page itself shows comes through say(): the English text is the key, and what a file of
 * languages/ has for it is shown. tests/tools/report/page/languages.test.mjs finds what is missing.
 */
const KEPT = "muster.language"; // in the browser's storage

/** The language that is spoken: its code, and its words by the English ones. */
let spoken = { code: "en", words: {} };

/** From now on say() speaks this language. The page does so once, before all else; the scene's script, which is unpacked later, again. */
export function speak(language) {
  spoken = language;
}

export const language = () => spoken;

/** Puts values in the place of "{name}"; a name that has none stays. */
export const fill = (text, values) => text.replace(/\{(\w+)\}/g, (all, name) => (Object.hasOwn(values, name) ? values[name] : all));

/** What the language has for a text: a text that begins with a capital may be there with a small letter alone. */
function found(text) {
  const { words } = spoken;
  if (Object.hasOwn(words, text)) return words[text];
  const small = text[0]?.toLowerCase() + text.slice(1);
  return Object.hasOwn(words, small) ? words[small][0].toUpperCase() + words[small].slice(1) : text.replace(/\|.*$/, "");
}

/** A text in the page's language: say("{n} of {total} tasks", { n: 2, total: 9 }). What stands after "|" tells texts apart and is not shown. */
export const say = (text, values = {}) => fill(found(text), values);

/** The same in parts, for an element's children: values may be elements. */
export function sayParts(text, values) {
  return say(text).split(/(\{\w+\})/).filter(Boolean).map((part) => {
    const name = part.slice(1, -1);
    return part[0] === "{" && Object.hasOwn(values, name) ? values[name] : part;
  });
}

/** The language of "#t=4800&lang=fr", else the remembered one, else English; `known`: the codes that there are. */
export function languageOf(hash, remembered, known) {
  const asked = new URLSearchParams(hash.replace(/^#/, "")).get("lang");
  return [asked, remembered].find((code) => known.includes(code)) ?? "en";
}

/** What a link has to say of the language; null: nothing, as this browser shows it in that language anyway. */
export const linkLanguage = () => (spoken.code === "en" && (kept() ?? "en") === "en" ? null : spoken.code);

/** The address' part "#..." with another language. */
export const hashWith = (hash, code) => `#${[...hash.replace(/^#/, "").split("&").filter((part) => part && !part.startsWith("lang=")), `lang=${code}`].join("&")}`;

/** The code that the browser remembers; null: none. */
export function kept() {
  try {
    return localStorage.getItem(KEPT);
  } catch {
    return null; // a browser that keeps nothing
  }
}

export function keep(code) {
  try {
    localStorage.setItem(KEPT, code);
  } catch { /* the same */ }
}

const ATTRIBUTES = ["aria-label", "placeholder", "title"];

/** Says what stands in the page's HTML in the page's language. */
export function sayAll(root) {
  const texts = document.createTreeWalker(root, NodeFilter.SHOW_TEXT, (node) =>
    (node.parentElement.closest("script, style") ? NodeFilter.FILTER_REJECT : NodeFilter.FILTER_ACCEPT));
  while (texts.nextNode()) {
    const node = texts.currentNode;
    const text = node.data.trim();
    if (text) node.data = node.data.replace(text, () => say(text));
  }
  for (const name of ATTRIBUTES) {
    for (const node of root.querySelectorAll(`[${name}]`)) node.setAttribute(name, say(node.getAttribute(name)));
  }
}
