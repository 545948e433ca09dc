/** What page and session say of datasets and their recordings: a part of protocol.ts. */
import { count, type Fields, fieldsOf, list, number, text } from "./reading";

/** A recording for a dataset: the one that runs, or the last. */
export interface DatasetStatus {
  name: string;
  performer: string;
  /** Its file's name. */
  take: string;
  /** Lines that were left when it began. */
  lines: number;
  /** Lines of its script that the performer had recorded before. */
  done: number;
  over: boolean;
  /** Why it ended early; empty when it did not. */
  error: string;
}

export interface DatasetPerformer {
  name: string;
  takes: number;
  /** That are recorded well, of any script. */
  lines: number;
}

export interface Dataset {
  name: string;
  performers: DatasetPerformer[];
}

export interface ScriptBlock {
  name: string;
  lines: number;
  seconds: number;
}

export interface Script {
  name: string;
  title: string;
  language: string;
  blocks: ScriptBlock[];
}

/** Which datasets there are, and what can be recorded for one. */
export interface DatasetList {
  datasets: Dataset[];
  scripts: Script[];
}

/** By key: until the performer goes on; by voice: until a text was spoken. */
export type Pace = "key" | "voice";

/** What a recording begins with. */
export interface DatasetWish {
  name: string;
  script: string;
  performer: string;
  recorded_by: string;
  purpose: string;
  sound: boolean;
  /** The face, on video beside the take. */
  video: boolean;
  /** The performer agreed. */
  agreed: true;
  pace: Pace;
}

export type DatasetCommand =
  | { command: "dataset"; list: true }
  | { command: "dataset"; begin: DatasetWish }
  | { command: "dataset"; end: true };

/** The session's limits, in letters; it counts bytes, and says so where they are too many. */
export const LONGEST = { dataset: 100, performer: 60, recordedBy: 200, purpose: 1000 } as const;

const MOST = 100_000;

export function readDataset(value: unknown): DatasetStatus | null {
  const fields = fieldsOf(value);
  const name = text(fields["name"]);
  if (name === "") return null;
  return {
    name,
    performer: text(fields["performer"]),
    take: text(fields["take"]),
    lines: count(fields["lines"], MOST),
    done: count(fields["done"], MOST),
    over: fields["over"] === true,
    error: text(fields["error"]),
  };
}

/** The answer to the list that was asked for. */
export function readDatasetList(result: Fields | null): DatasetList {
  const fields = fieldsOf(result);
  const named = <T extends { name: string }>(all: T[]) => all.filter((one) => one.name !== "");
  return {
    datasets: named(list(fields["datasets"], (one) => ({
      name: text(one["name"]),
      performers: named(list(one["performers"], (performer) => ({
        name: text(performer["name"]),
        takes: count(performer["takes"], MOST),
        lines: count(performer["lines"], MOST),
      }))),
    }))),
    scripts: named(list(fields["scripts"], (one) => ({
      name: text(one["name"]),
      title: text(one["title"]) || text(one["name"]),
      language: text(one["language"]),
      blocks: list(one["blocks"], (block) => ({
        name: text(block["name"]),
        lines: count(block["lines"], MOST),
        seconds: Math.max(0, number(block["seconds"])),
      })),
    }))),
  };
}

/** The performer of a dataset, where both are known. */
export function performerOf(known: DatasetList | null, dataset: string, performer: string): DatasetPerformer | null {
  return known?.datasets.find((one) => one.name === dataset)?.performers.find((one) => one.name === performer) ?? null;
}
