/**
 * What the server answers.
 *
 * @typedef {{name: string, normals: "dx" | "gl" | null, proposed?: boolean}} Plane
 * @typedef {{id: string, name: string, width: number, height: number, planes: Plane[], depth: number, created: number,
 *   from?: string, told?: string[]}} Exemplar `from`: the result that it is; `told`: what of its files is not used
 * @typedef {"queued" | "running" | "done" | "failed" | "cancelled" | "interrupted"} State
 * @typedef {Record<string, any>} Options values of options by name; those left out are automatic
 * @typedef {{id: string, verb: string, exemplars: string[], options: Options, state: State, fraction: number | null,
 *   stage: string | null, error: string | null, created: number, began: number | null, ended: number | null,
 *   result: string | null, label: string | null, score: number | null, ready: number | null,
 *   name?: string}} Job times in seconds since 1970
 * @typedef {{worth: number, measured: number, unit: string, loss: number, weight: number}} Part
 * @typedef {{total: number, verdict: string, parts: Record<string, Part>}} Score
 * @typedef {{overlays?: string[], reason: string, lattice?: {periods: number[], reasons?: string[]} | null,
 *   elements?: {size: number[]} | null, segments?: {count: number} | null,
 *   courses?: {count?: number} | unknown[] | null, suggested?: {method: string, why?: string[]} | null,
 *   light?: {strong: boolean} | null}} Found
 * @typedef {{name: string, holds: string, bytes: number}} Made
 * @typedef {{id: string, job: string, verb: string, size: [number, number], files: Made[], options: Options, command: string,
 *   inputs: Record<string, string>, told: {method?: string, blend?: {feather: number}} | null, python: string, score: Score | null}} Result
 * @typedef {{name: string, kind: string, help: string, default: unknown, low: number | null, high: number | null,
 *   unit?: string, choices: string[]}} Option
 * @typedef {{slug: string, paper: string, summary: string, supports: string[], parameters: Option[]}} Method
 * @typedef {{verbs: Record<string, Option[]>, methods: Method[], samples: string[]}} Schema
 */

export {};
