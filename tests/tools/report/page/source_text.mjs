// JavaScript as tokens, as far as the tests of the page's texts need it.

const BEFORE_REGEX = /^(?:[([{,;:=!&|?+\-*%<>~^}]|=>|return|typeof|case|in|of|&&|\|\||\?\?|[!=]==?|\.\.\.)$/;
const MARKS = ["...", "===", "!==", "??=", "||=", "&&=", "**=", "=>", "==", "!=", "<=", ">=", "&&", "||", "??", "?.", "++", "--", "+=", "-=", "*=", "/=", "<<", ">>", "**"];
const ESCAPES = { n: "\n", t: "\t" };

/** Whether "/" begins a regular expression after that token; else it divides. */
const mayBeRegex = (token) => !token || token.type === "template" || (["mark", "word"].includes(token.type) && BEFORE_REGEX.test(token.text));

/** A string's text from after its quote at `i`, up to `end` or, in a template, "${": [text, where it ends]. */
function quoted(source, i, end) {
  let text = "";
  for (; source[i] !== end; ++i) {
    if (i >= source.length) throw new Error(`no ${end} after ${text.slice(0, 80)}`);
    if (end === "`" && source.startsWith("${", i)) break;
    if (source[i] === "\\") text += ESCAPES[source[++i]] ?? source[i];
    else text += source[i];
  }
  return [text, i];
}

/** Where a regular expression that begins at `i` ends. */
function afterRegex(source, i) {
  for (let within = false; ; ) {
    const letter = source[++i];
    if (letter === "\n" || letter === undefined) throw new Error(`no end of ${source.slice(i - 40, i)}`);
    if (letter === "\\") ++i;
    else if (letter === "[") within = true;
    else if (letter === "]") within = false;
    else if (letter === "/" && !within) break;
  }
  while (/[a-z]/.test(source[i + 1])) ++i;
  return i + 1;
}

/** { type: "string" | "template" | "word" | "mark" | "regex", text, line }; a template is its parts, with the tokens between them. */
export function tokensOf(source) {
  const tokens = [];
  const open = []; // what closes: "}" of code, "`" of code within a template
  let line = 1;
  const put = (type, text, from, to) => {
    tokens.push({ type, text, line });
    line += source.slice(from, to).split("\n").length - 1;
    return to;
  };
  const template = (i) => {
    const [text, to] = quoted(source, i, "`");
    const goesOn = source[to] === "$";
    if (goesOn) open.push("`");
    return put("template", text, i, to + (goesOn ? 2 : 1));
  };
  for (let i = 0; i < source.length;) {
    const [space] = /^(?:\s+|\/\/.*|\/\*[^]*?\*\/)/.exec(source.slice(i)) ?? [];
    if (space) {
      line += space.split("\n").length - 1;
      i += space.length;
    } else if (source[i] === '"' || source[i] === "'") {
      const [text, to] = quoted(source, i + 1, source[i]);
      i = put("string", text, i, to + 1);
    } else if (source[i] === "`") {
      i = template(i + 1);
    } else if (source[i] === "/" && mayBeRegex(tokens.at(-1))) {
      const to = afterRegex(source, i);
      i = put("regex", source.slice(i, to), i, to);
    } else if (/[\w$#]/.test(source[i])) {
      const [word] = /^[\w$#]+/.exec(source.slice(i));
      i = put("word", word, i, i + word.length);
    } else if (source[i] === "}" && open.pop() === "`") {
      i = template(i + 1);
    } else {
      if (source[i] === "{") open.push("}");
      const mark = MARKS.find((one) => source.startsWith(one, i)) ?? source[i];
      i = put("mark", mark, i, i + mark.length);
    }
  }
  return tokens;
}

const DEEPER = { "(": 1, "[": 1, "{": 1, ")": -1, "]": -1, "}": -1 };

/** The arguments of a call whose "(" is token `i`: from and to of their tokens. */
export function argumentsAt(tokens, i) {
  const found = [{ from: i + 1, to: i + 1 }];
  for (let deep = 1; ; ) {
    const { type, text } = tokens[++i];
    if (type === "mark") deep += DEEPER[text] ?? 0;
    if (deep === 0) break;
    if (deep === 1 && type === "mark" && text === ",") found.push({ from: i + 1, to: i + 1 });
    else found.at(-1).to = i + 1;
  }
  return found;
}
