// SPDX-License-Identifier: Apache-2.0
// Tables of a page: columns with a name, a unit and a meaning, as those of the CSV files.

export interface Column {
  name: string;
  unit: string;
  meaning: string;
  whole: boolean; ///< integers
  words: string[] | null; ///< values are their numbers
  values: Float32Array;
}

/// What a page says of a column beside its values.
export interface ColumnMeta { table: string; name: string; unit: string; meaning: string; whole?: boolean; words?: string[] }

export const columnsIn = (raw: unknown): ColumnMeta[] =>
  Array.isArray(raw) ? (raw as Partial<ColumnMeta>[]).map((c) => ({ table: String(c?.table), name: String(c?.name), unit: String(c?.unit ?? ""), meaning: String(c?.meaning ?? ""), whole: c?.whole === true, words: Array.isArray(c?.words) ? c.words.map(String) : undefined })) : [];

export const columnOf = (c: ColumnMeta, values: Float32Array): Column => ({ name: c.name, unit: c.unit, meaning: c.meaning, whole: c.whole === true, words: c.words ?? null, values });

/// How an entry of a table is written.
export function textOf(column: Column, row: number, short: (x: number, digits?: number) => string): string {
  const x = column.values[row]!;
  if (column.words) return column.words[x] || "–";
  return column.whole && Number.isFinite(x) ? String(x).replace("-", "−") : short(x, 4);
}

const RAISED: Record<string, string> = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴" };
/// A unit as people write it: "°", "mm³" of "mm^3".
export const unitText = (unit: string): string => (unit === "degrees" ? "°" : unit.replace(/\^(-?[0-4]+)/g, (_, power: string) => [...power].map((c) => RAISED[c]).join("")));
