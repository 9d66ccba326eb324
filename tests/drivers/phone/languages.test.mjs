// The phone's page in its languages: every text is there, with the same values.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { LANGUAGES, languageOf, say, speak } from "../../../drivers/phone/page/language.mjs";

const PHONE = join(dirname(fileURLToPath(import.meta.url)), "../../../drivers/phone");
const source = (name) => readFileSync(join(PHONE, name), "utf8");

/** The texts in double quotes of the first argument of every call of that name, without those that something is compared with. */
function saidBy(name, code) {
  const found = [];
  for (const { index } of code.matchAll(new RegExp(`\\b${name}\\(`, "g"))) {
    let depth = 0;
    for (let i = code.indexOf("(", index); ; ++i) {
      if (code[i] === '"') {
        const [text] = code.slice(i).match(/^"(?:[^"\\]|\\.)*"/);
        if (!/[!=]== $/.test(code.slice(0, i))) found.push(JSON.parse(text));
        i += text.length - 1;
      } else if ("([{".includes(code[i])) ++depth;
      else if (")]}".includes(code[i])) --depth;
      if (depth === 0 || (depth === 1 && code[i] === ",")) break;
    }
  }
  return found;
}

const listed = (code, name) => [...code.match(new RegExp(`const ${name} = [^;]*;`))[0].matchAll(/"([^"]*)"/g)].map(([, text]) => text);

/** Every text that the page can show by itself. */
function texts() {
  const html = [...source("page/index.html").matchAll(/(?:data-say|aria-label|<option value)="([^"]*)"/g)].map(([, text]) => text);
  const [page, words, ...others] = ["page.mjs", "words.mjs", "map.mjs", "noise.mjs"].map((name) => source(`page/${name}`));
  return new Set([...html, ...[page, words, ...others].flatMap((code) => saidBy("say", code)), ...listed(page, "WORDS"), ...listed(words, "TURNS"),
    ...listed(words, "COURSES").map((course) => `to the ${course}`), ...saidBy("Refusal", source("phone.mjs"))]);
}

const valuesIn = (text) => [...text.matchAll(/\{\w+\}/g)].map(([value]) => value).sort();

for (const code of Object.keys(LANGUAGES).filter((one) => one !== "en")) {
  test(`${code} has every text, with the same values, and no other`, async () => {
    const { default: words } = await import(`../../../drivers/phone/page/${code}.mjs`);
    const wanted = texts();
    assert.ok(wanted.size > 90, `${wanted.size} texts`);
    assert.deepEqual([...wanted].filter((text) => !Object.hasOwn(words, text)), [], "missing");
    assert.deepEqual(Object.keys(words).filter((text) => !wanted.has(text)), [], "shown nowhere");
    for (const [text, translated] of Object.entries(words)) assert.deepEqual(valuesIn(translated), valuesIn(text), text);
  });
}

test("the browser's language is spoken, if there is no other choice", () => {
  assert.equal(languageOf(null, ["de-CH", "fr-CH", "en"]), "fr");
  assert.equal(languageOf("zh", ["fr"]), "zh");
  assert.equal(languageOf("xx", []), "en");
  assert.equal(languageOf("constructor", ["toString"]), "en");
});

test("what is not there is said in English", () => {
  speak({ "By {when}": "Avant {when}" });
  assert.equal(say("By {when}", { when: "0:10" }), "Avant 0:10");
  assert.equal(say("With {partner}", { partner: "uav:3" }), "With uav:3");
  assert.equal(say("constructor"), "constructor");
  speak({});
});
