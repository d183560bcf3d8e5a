import js from "@eslint/js";

export default [
  {
    ...js.configs.recommended,
    files: ["**/*.js"],
    rules: {
      ...js.configs.recommended.rules,
      complexity: ["error", 16],
      eqeqeq: "error",
      "max-lines": ["error", 250],
      "no-undef": "off", // tsc knows what a browser has
      "no-unused-vars": "off", // and what is used
      "no-var": "error",
      "prefer-const": "error",
    },
  },
];
