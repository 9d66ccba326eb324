// The page's language: the English text is the key, and what fr.mjs, es.mjs or zh.mjs has for it is shown.

export const LANGUAGES = { en: "English", fr: "Français", es: "Español", zh: "中文" };

let spoken = {};

/** From now on say() speaks so: texts by the English ones. */
export function speak(texts) {
  spoken = texts;
}

/** A text in the page's language, with values in the place of "{name}". */
export function say(text, values = {}) {
  const found = Object.hasOwn(spoken, text) ? spoken[text] : text;
  return found.replace(/\{(\w+)\}/g, (all, name) => (Object.hasOwn(values, name) ? values[name] : all));
}

/** The remembered language, or the first of the browser's that there is. */
export function languageOf(remembered, wanted) {
  return [remembered, ...wanted.map((tag) => tag.split("-")[0])].find((code) => Object.hasOwn(LANGUAGES, code ?? "")) ?? "en";
}
