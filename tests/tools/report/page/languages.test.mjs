// The page's languages: what is shown in English is there in each of them, and nothing shown is English alone. Without a browser.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { hashWith, languageOf, say, sayParts, speak } from "../../../../tools/report/page/language.js";
import { argumentsAt, tokensOf } from "./source_text.mjs";

const at = (path) => fileURLToPath(new URL(`../../../../${path}`, import.meta.url));
const PAGE = "tools/report/page";
const read = (path) => readFileSync(at(path), "utf8");
const SOURCES = ["", "/layers", "/scene"].flatMap((folder) => readdirSync(at(`${PAGE}${folder}`)).filter((name) => name.endsWith(".js"))
  .map((name) => ({ name: `${folder}/${name}`.slice(1), tokens: tokensOf(read(`${PAGE}${folder}/${name}`)) })));
const LANGUAGES = Object.fromEntries(readdirSync(at(`${PAGE}/languages`)).map((name) => [name.replace(".json", ""), JSON.parse(read(`${PAGE}/languages/${name}`))]));

const hasWords = (text) => /[A-Za-z]{2}/.test(text);
const namesIn = (text) => [...text.matchAll(/\{\w+\}/g)].map(([name]) => name).sort().join();

/** Whether a token is a string that nothing is compared with. */
function isString(tokens, i) {
  const isComparison = (token) => token?.type === "mark" && /^[!=]==$/.test(token.text);
  return tokens[i].type === "string" && !isComparison(tokens[i - 1]) && !isComparison(tokens[i + 1]);
}

const isSay = (tokens, i) => ["say", "sayParts"].includes(tokens[i].text) && tokens[i].type === "word" && tokens[i + 1]?.text === "(" && tokens[i - 1]?.text !== "function";

/** The texts that a source says, with the places of their tokens. */
function saidIn({ name, tokens }) {
  return tokens.flatMap((_, i) => {
    if (!isSay(tokens, i)) return [];
    const [{ from, to }] = argumentsAt(tokens, i + 1);
    const said = tokens.slice(from, to);
    assert.ok(!said.some(({ type }) => type === "template"), `${name}:${tokens[i].line}: say() takes texts with {names}, no template`);
    return [{ from, to, texts: said.filter(({ text }, at) => isString(said, at) && hasWords(text)).map(({ text }) => text) }];
  });
}

/** The texts of the page's HTML: between tags, and attributes that are shown or read out. */
function htmlTexts() {
  const body = read(`${PAGE}/index.html`).replace(/^[^]*<body>/, "").replace(/<!--[^]*?-->|<script>[^]*?<\/script>/g, "");
  const between = [...body.matchAll(/>([^<>]+)</g)].map(([, text]) => text.trim());
  const attributes = [...body.matchAll(/ (?:aria-label|placeholder|title)="([^"]*)"/g)].map(([, text]) => text);
  return [...between, ...attributes].filter((text) => hasWords(text) && !UNTRANSLATED.includes(text));
}

/** In the page's HTML, and the same everywhere: its name, a text that scripts replace at once, keys of the keyboard, units, a name of an agent. */
const UNTRANSLATED = ["Muster", "space", "shift", "Home", "End", "Tab", "Enter", "Esc", "20 min", "uav:3"];

/** Words that come with the data: those of the wire (lcmtypes/words.h) as they are shown, states of a live page and of orders. */
function dataWords() {
  const header = read("lcmtypes/words.h");
  const wire = ["AgentStatus", "TaskStatus", "ActivityKind", "ProcessState", "EventKind", "FaultKind"].flatMap((kind) => {
    const [, names] = new RegExp(`kNames<${kind}> = \\{([^}]*)\\}`).exec(header);
    return [...names.matchAll(/"(\w+)"/g)].map(([, name]) => name.replaceAll("_", " "));
  });
  const [, untold] = /\[([^\]]*)\]\.includes\(e\.kind\)/.exec(read(`${PAGE}/panels.js`)); // events that no table has
  const live = [...read(`${PAGE}/data.js`).matchAll(/status\("(\w+)"\)/g)].map(([, word]) => word);
  return [...wire.filter((word) => !untold.includes(`"${word.replaceAll(" ", "_")}"`)), ...live, "connecting", "live", "ended", "pending", "taken", "refused", "withdrawn"];
}

/** Units and marks that are the same in all languages. */
const UNITS = /\b(?:km|m|m²|min|h|d|s|ms|kB|MB|GB|k|UTC|GMT)\b/g;
/** Calls that show their arguments, from the first to the second of these; and properties that are shown. */
const ALL = [0, Infinity];
const SHOWING = { element: [2, Infinity], append: ALL, replaceChildren: ALL, createTextNode: ALL, fillText: [0, 0], strokeText: [0, 0], fact: [0, 0], tile: [1, 1],
  field: [0, 0], ChartTable: [0, 0], Error: ALL };
const SHOWN = ["textContent", "innerText", "title", "words", "more", "button", "text", "note", "why", "what", "label", "aria-valuetext", "aria-label", "placeholder", "alt", "innerHTML", "data"];
/** Calls whose arguments are names of the program's own. */
const NAMING = /^(?:on|once|emit|querySelector|querySelectorAll|matches|closest|matchMedia|stamp|RegExp|addEventListener|getContext|draw|kept)$/;
/** What only looks like texts: fonts, styles of elements, marks of SVG, and names that the program itself knows things by. */
const NO_TEXT = [/sans-serif/, /^(?:width|background|translate)\b/, /^</, /^(?:uav|worker|vehicle|task|charging point)[ :@]$/];
/** Texts that the scan finds and that are right as they are. */
const EXCEPTIONS = [
  "attention.js: never", "attention.js: open", // filters of the task table, by their ids
  "base_map.js: status ", // an error that is caught
  "card.js: muster explain ", // a command
  "main.js:  – Muster", // a name
  "names.js: charging point @", // as explanations have it
  "tasks.js: 17, uav:3", // an example of names
  "tasks.js: #task-table tr", // a selector
];

/** What each token stands in, from within: { call, first (its first argument), argument (which one) } of a call, { key } of an object. */
function framesOf(tokens) {
  const frames = [];
  return tokens.map((token, i) => {
    const { type, text } = token;
    const top = frames.at(-1);
    if (type === "mark" && [")", "]", "}"].includes(text)) frames.pop();
    else if (type === "mark" && text === "," && top) {
      ++top.argument;
      top.key = null;
    } else if (type === "mark" && text === ";" && top) top.key = null;
    else if (tokens[i + 1]?.text === ":" && tokens[i + 1].type === "mark" && top?.opens === "{" && top.key === null) top.key = text;
    else if (type === "word" && tokens[i - 1]?.text === "." && tokens[i + 1]?.text === "=" && SHOWN.includes(text)) {
      if (top) top.key = text;
    }
    const all = [...frames].reverse().map((frame) => ({ ...frame }));
    if (type === "mark" && ["(", "[", "{"].includes(text)) {
      const call = text === "(" && tokens[i - 1]?.type === "word" ? tokens[i - 1].text : null;
      frames.push({ opens: text, call, first: tokens[i + 1].text, argument: 0, key: null });
    }
    return all;
  });
}

/** Whether a text that stands in these frames is shown. */
function isShown(frames) {
  for (const { opens, call, first, argument, key } of frames) {
    if (opens === "{") return SHOWN.includes(key);
    if (call === "setAttribute" && SHOWN.includes(first)) return argument === 1;
    if (call && SHOWING[call]) return argument >= SHOWING[call][0] && argument <= SHOWING[call][1];
    if (call && !["if", "while", "for"].includes(call)) return false;
  }
  return false;
}

const isName = (frames) => frames[0]?.opens === "{" && ["class", "style", "viewBox"].includes(frames[0].key);

/** Texts that do not come through say() though they are, or look as if they were, shown: "card.js: text". */
function evadingIn(source) {
  const { name, tokens } = source;
  const said = new Set(saidIn(source).flatMap(({ from, to }) => Array.from({ length: to - from }, (_, i) => from + i)));
  const frames = framesOf(tokens);
  const isKey = (i) => tokens[i + 1].text === ":" && ["{", ","].includes(tokens[i - 1].text);
  const strings = new Set(tokens.flatMap((token, i) => (token.type === "template" || (isString(tokens, i) && !isKey(i)) ? [i] : [])));
  return tokens.flatMap(({ text }, i) => {
    if (!strings.has(i) || said.has(i) || ["from", "import"].includes(tokens[i - 1]?.text) || isName(frames[i])) return [];
    const words = text.replace(UNITS, "");
    if (!hasWords(words) || NO_TEXT.some((pattern) => pattern.test(words)) || NAMING.test(frames[i][0]?.call)) return [];
    return isShown(frames[i]) || /[A-Za-z]{2}[,;:.]? [A-Za-z]{2}/.test(words) ? [`${name}: ${text}`] : [];
  });
}

const ALL_TEXTS = new Set([...SOURCES.flatMap(saidIn).flatMap(({ texts }) => texts), ...htmlTexts(), ...dataWords()]);
const small = (text) => text[0].toLowerCase() + text.slice(1);
/** "Tasks" is made of "tasks" where there is that. */
const KEYS = new Set([...ALL_TEXTS].filter((text) => text === small(text) || !ALL_TEXTS.has(small(text))));

test("there are languages, and the page offers each", () => {
  for (const code of ["es", "fr", "zh"]) assert.ok(LANGUAGES[code], code);
  const offered = read(`${PAGE}/languages.js`);
  for (const code of Object.keys(LANGUAGES)) assert.match(offered, new RegExp(`${code}: \\["[^"]+", ${code}\\]`));
});

for (const [code, words] of Object.entries(LANGUAGES)) {
  test(`${code}: every text of the page is there, with the same names, and no other`, () => {
    assert.deepEqual([...KEYS].filter((key) => !Object.hasOwn(words, key)), [], `${code}.json lacks these`);
    assert.deepEqual(Object.keys(words).filter((key) => !KEYS.has(key)), [], `${code}.json has these, which nothing says`);
    for (const [key, text] of Object.entries(words)) {
      assert.ok(text.trim(), `${code}: "${key}" is empty`);
      assert.equal(namesIn(text), namesIn(key), `${code}: "${key}" has other names in braces: "${text}"`);
    }
  });
}

test("no text is shown that does not come through say()", () => {
  assert.deepEqual([...new Set(SOURCES.flatMap(evadingIn))].sort(), EXCEPTIONS.sort());
});

const english = { code: "en", words: {} };

test("say() puts values in; what a language lacks is said in English", (t) => {
  t.after(() => speak(english));
  assert.equal(say("{n} of {total} tasks", { n: 2, total: 9 }), "2 of 9 tasks");
  assert.equal(say("{a}, {b}", { a: "{b}" }), "{b}, {b}", "values are put in once; a name without a value stays");
  assert.equal(say("Open|roads"), "Open", "what tells texts apart is not shown");
  speak({ code: "xx", words: { "{n} of {total} tasks": "{total}: {n}", tasks: "taskoj", "Open|roads": "Malfermi" } });
  assert.deepEqual([say("{n} of {total} tasks", { n: 2, total: 9 }), say("Open|roads"), say("Open"), say("toString")], ["9: 2", "Malfermi", "Open", "toString"]);
  assert.deepEqual([say("tasks"), say("Tasks"), say(""), say("–")], ["taskoj", "Taskoj", "", "–"], "a capital is made of a small letter");
});

test("a text in parts has its values where the language has them", (t) => {
  t.after(() => speak(english));
  const bold = { bold: true };
  assert.deepEqual(sayParts("{a} at {b}.", { a: bold, b: 3 }), [bold, " at ", 3, "."]);
  speak({ code: "xx", words: { "{a} at {b}.": "je {b}: {a}" } });
  assert.deepEqual(sayParts("{a} at {b}.", { a: bold, b: 3 }), ["je ", 3, ": ", bold]);
});

test("the language is the link's, else the remembered one, else English; a link keeps the rest when another is chosen", () => {
  const codes = ["en", "fr"];
  assert.deepEqual([languageOf("#t=5&lang=fr", "en", codes), languageOf("#lang=xx", "fr", codes), languageOf("#t=5", "xx", codes), languageOf("", null, codes)], ["fr", "fr", "en", "en"]);
  assert.equal(hashWith("#t=4800&sel=uav:2,task:17&lang=fr", "es"), "#t=4800&sel=uav:2,task:17&lang=es");
  assert.equal(hashWith("", "fr"), "#lang=fr");
});

// Last: modules that are imported from here on have French texts.
test("a French page: sentences, data's words, links in them; what is sent stays as it is", async () => {
  speak({ code: "fr", words: LANGUAGES.fr });
  const page = (name) => import(`../../../../tools/report/page/${name}.js`);
  const { begun } = await import("./small_run.mjs");
  const [{ describe }, { mentions }, { Orders, orderWords, ordersOf }, { attentionAt }, { writeLink }, { linkLanguage }, { matcherOf }] = await Promise.all(
    ["describe", "names", "orders", "attention", "link", "language", "tasks"].map(page));
  const run = begun({ now_ms: 700000, spans: [[0, 0, [0, 6]]], stops: [[0, 0, [0, 100, 100, 12300]]] });
  assert.equal(describe(run, { type: "agent", index: 0 }, 1000), "uav:0: en panne, reste 12.3 sur 30 km");
  assert.equal(describe(run, { type: "task", id: 1 }, 1000), "tâche 1\u00a0: à pourvoir, consomme 0.1 km d’autonomie");
  assert.deepEqual(attentionAt(run, 1000).map(({ text, note }) => `${text}: ${note}`), ["uav:0: depuis 0:00:00"]);
  const linked = (text) => mentions(run, text).filter(({ item }) => item).map(({ text: name, item }) => [name, item.type, item.id ?? item.index]);
  assert.deepEqual(linked("vers la tâche 1 avec uav:0, au point de recharge 0"), [["tâche 1", "task", 1], ["uav:0", "agent", 0], ["point de recharge 0", "charge", 0]]);
  assert.deepEqual(linked("task 1 is nearer than task 7 and charging point 0"), [["task 1", "task", 1], ["charging point 0", "charge", 0]], "explanations are in English");
  assert.ok(matcherOf("tâche 1")({ id: 1, who: "", name: "" }));
  assert.equal(orderWords({ order: "task_hold", task: 1 }), "suspendre la tâche 1");
  assert.deepEqual(ordersOf("task", 0), [["Modifier …", "task_change"], ["Suspendre", "task_hold"], ["Annuler la tâche", "task_cancel"], ["Affecter ou interdire …", "pin"]]);
  const sent = [];
  const orders = new Orders("token", () => {}, async (address, { body }) => {
    sent.push(JSON.parse(body));
    return { status: 200, json: async () => ({ taken: { sim_s: 90 } }) };
  });
  await orders.give({ order: "task_hold", task: 1 }, 0);
  assert.deepEqual([sent[0].order, sent[0].task, orders.list[0].state, orders.list[0].note], ["task_hold", 1, "taken", "accepté à 0:01:30"]);
  assert.equal(writeLink({ tMs: 0, sel: null, run: 0, look: "map", lang: linkLanguage() }), "#t=0&lang=fr");
});
