// What scripts/lint-js checks. Pages run in Chrome 110, Firefox 115, Safari 16.4 and later ones, programs in Node 18. Each rule is
// meant: what is found is mended, not silenced.
import js from "@eslint/js";
import stylistic from "@stylistic/eslint-plugin";
import globals from "globals";

// Functions younger than these browsers and this Node: ES2023's copies of arrays, and what came after.
const YOUNGER = ["toSorted", "toReversed", "toSpliced", "with", "groupBy", "withResolvers", "fromAsync", "isWellFormed",
  "toWellFormed", "canParse", "union", "intersection", "difference", "symmetricDifference", "isSubsetOf", "isSupersetOf",
  "isDisjointFrom"];
const PAGES = ["tools/report/page/**", "drivers/phone/page/**"];

export default [
  js.configs.recommended,
  {
    files: ["**/*.{js,mjs}"],
    plugins: { "@stylistic": stylistic },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    languageOptions: { ecmaVersion: 2022 },
    rules: {
      "no-restricted-properties": ["error", ...YOUNGER.map((property) => ({ property, message: "is younger than Node 18 or Safari 16.4" })),
        { object: "AbortSignal", property: "any", message: "is younger than Node 18" }],
      "array-callback-return": "error",
      "default-case-last": "error",
      "eqeqeq": ["error", "always", { null: "ignore" }],
      "max-lines": ["error", 500],
      "max-lines-per-function": ["error", 80],
      "no-constructor-return": "error",
      "no-self-compare": "error",
      "no-shadow": "error",
      "no-template-curly-in-string": "error",
      "no-throw-literal": "error",
      "no-unreachable-loop": "error",
      "no-useless-assignment": "error",
      "no-unused-vars": ["error", { ignoreRestSiblings: true }],
      "no-var": "error",
      "object-shorthand": "error",
      "prefer-const": "error",
      "prefer-template": "error",
      "@stylistic/arrow-parens": "error",
      "@stylistic/brace-style": ["error", "1tbs", { allowSingleLine: true }],
      "@stylistic/comma-spacing": "error",
      "@stylistic/eol-last": "error",
      "@stylistic/indent": ["error", 2, { SwitchCase: 1, flatTernaryExpressions: true }],
      "@stylistic/keyword-spacing": "error",
      "@stylistic/max-len": ["error", { code: 160, ignoreStrings: true, ignoreTemplateLiterals: true }],
      "@stylistic/no-multiple-empty-lines": ["error", { max: 1 }],
      "@stylistic/no-trailing-spaces": "error",
      "@stylistic/object-curly-spacing": ["error", "always"],
      "@stylistic/quotes": ["error", "double", { avoidEscape: true }],
      "@stylistic/semi": "error",
      "@stylistic/space-before-blocks": "error",
      "@stylistic/space-infix-ops": "error",
    },
  },
  { ignores: PAGES, languageOptions: { globals: globals.node } },
  // Tests run some of their code in pages, and name things as node:test does.
  { files: [...PAGES, "tests/**"], languageOptions: { globals: globals.browser } },
  { files: ["tests/**"], rules: { "no-shadow": "off", "@stylistic/max-len": "off" } },
];
