// The types of the bundle are those of its parts.
export * from "./parts.js";
