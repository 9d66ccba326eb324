import { element } from "./dom.js";
import { hashWith, keep, kept, language, languageOf, sayAll, speak } from "./language.js";
import es from "./languages/es.json";
import fr from "./languages/fr.json";
import zh from "./languages/zh.json";

/** The languages that can be chosen, by their codes: [name, words]. */
const LANGUAGES = { en: ["English", {}], fr: ["Français", fr], es: ["Español", es], zh: ["中文", zh] };

// Here and not in a function: modules that are imported later have texts of their own.
const chosen = languageOf(location.hash, kept(), Object.keys(LANGUAGES));
speak({ code: chosen, words: LANGUAGES[chosen][1] });

/** Says the page's HTML in its language, and fills the menu in which another is chosen: the page is loaded again then. */
export function offerLanguages(select) {
  const { code: spoken } = language();
  document.documentElement.lang = spoken;
  if (spoken !== "en") sayAll(document.body);
  select.append(...Object.entries(LANGUAGES).map(([code, [name]]) => element("option", { value: code, lang: code, selected: code === spoken }, name)));
  select.addEventListener("change", () => {
    keep(select.value);
    speak({ ...language(), code: select.value }); // the address may be written once more before the page goes
    history.replaceState(null, "", hashWith(location.hash, select.value));
    location.reload();
  });
}
