// Datasets of the mock session: which there are, and a recording for one, as docs/reference/page_protocol.md has it.
import { MockPrompts } from "./mock_prompts.mjs";

const SMILE = { mouthSmile_L: 1, mouthSmile_R: 1, cheekSquint_L: 0.5, cheekSquint_R: 0.5 };
const read = (name, text, seconds, more) => ({ name, text, seconds, own_pace: true, language: "en", ...more });

const ENGLISH = [
  read("calm 1", "The lighthouse keeper wrote down the weather every evening, and nobody ever read it but the gulls.", 8, { block: "calm", say: "Read calmly", emotion: "neutral" }),
  read("calm 2", "When sunlight strikes raindrops in the air, they act as a prism and form a rainbow. The rainbow is a division of white light into many beautiful colours. These take the shape of a long round arch, with its path high above, and its two ends apparently beyond the horizon.", 18, { block: "calm", say: "Read calmly", emotion: "neutral" }),
  read("calm 3", "Tea, please.", 3, { block: "calm", say: "Read calmly", emotion: "neutral" }),
  { name: "broad smile", say: "Smile as wide as you can", seconds: 4, block: "expressions", emotion: "joy", target: SMILE },
  { name: "jaw open", say: "Open your mouth wide", seconds: 3, block: "expressions", emotion: "surprise", target: { jawOpen: 1, browInnerUp_L: 0.8, browInnerUp_R: 0.8 } },
  read("glad", "You came! You really came!", 4, { block: "expressions", say: "Say it with a smile", emotion: "joy", target: SMILE }),
  read("farewell", "I kept your letters. All of them.", 5, { block: "emotional", say: "Quietly, as to somebody who has left", emotion: "sadness" }),
  read("enough", "Enough! Not one more word, not one!", 4, { block: "emotional", say: "Out loud", emotion: "anger" }),
];

const ARABIC = [
  { ...read("هدوء 1", "كان حارس المنارة يكتب حالة الطقس كل مساء، ولم يقرأها أحد سوى النوارس.", 8, { block: "calm", say: "اقرأ بهدوء", emotion: "neutral" }), language: "ar" },
];

const SCRIPTS = [
  { name: "dataset_en", title: "Dataset, English", language: "en", lines: ENGLISH },
  { name: "dataset_ar", title: "مجموعة بيانات", language: "ar", lines: ARABIC },
];

export class MockDataset {
  /** As `status` has it. */
  state = null;
  datasets = [{ name: "faces", performers: [{ name: "anna", takes: 2, lines: 3 }, { name: "ben", takes: 1, lines: 8 }] }];
  /** Takes of datasets, by dataset and name. */
  takes = [];
  /** What will be poor in the recordings to come, as MockPrompts has it. */
  faults = {};

  constructor(session) {
    this.session = session;
  }

  list() {
    const blocks = (lines) => {
      const all = [];
      for (const { block, seconds } of lines) {
        if (all.at(-1)?.name !== block) all.push({ name: block, lines: 0, seconds: 0 });
        all.at(-1).lines += 1;
        all.at(-1).seconds += seconds;
      }
      return all;
    };
    return { datasets: this.datasets, scripts: SCRIPTS.map(({ lines, ...script }) => ({ ...script, blocks: blocks(lines) })) };
  }

  obey(command) {
    if (command.list) return this.list();
    if (command.begin) return this.begin(command.begin);
    if (command.end) {
      this.finish();
      return null;
    }
    throw new Error("a dataset is listed, begun or ended");
  }

  begin({ name, script, performer, agreed, video }) {
    if (agreed !== true) throw new Error("the performer has not agreed to be recorded");
    if (/^\.|[/\\]/.test(name)) throw new Error(`not a name for a dataset (${name}): letters, digits, - and _`);
    if (this.session.recording.on) throw new Error("a recording runs already: end it first");
    const lines = SCRIPTS.find((one) => one.name === script)?.lines;
    if (!lines) throw new Error(`there is no script ${script}`);
    const known = this.performer(name, performer);
    const left = lines.slice(script === "dataset_en" ? known.lines : 0);
    if (left.length === 0) throw new Error("everything of the script is recorded");
    const take = `${performer}_${known.takes + 1}.mien`;
    this.state = { name, performer, take, lines: left.length, done: lines.length - left.length, over: false, error: null };
    this.session.prompts = Object.assign(new MockPrompts(left), { faults: this.faults });
    this.session.recording = { on: true, path: `takes/${name}/${take}`, since: this.session.now(), error: null };
    if (video === true) this.session.video.allow(take);
    return { take: `takes/${name}/${take}`, lines: left.length, done: this.state.done };
  }

  performer(dataset, name) {
    const performers = this.datasets.find((one) => one.name === dataset)?.performers ?? [];
    return performers.find((one) => one.name === name) ?? { name, takes: 0, lines: 0 };
  }

  /** The disk is full, or whatever else ends it. */
  fail(error) {
    this.finish(error);
  }

  follow() {
    if (this.state && !this.state.over && this.session.prompts?.state === "over") this.finish();
  }

  finish(error = null) {
    if (!this.state || this.state.over) return;
    const { name, performer, take } = this.state;
    Object.assign(this.state, { over: true, error });
    this.session.video.finish();
    this.session.prompts.at = this.session.prompts.prompts.length;
    const seconds = this.session.now() - this.session.recording.since;
    this.session.recording = { on: false, path: `takes/${name}/${take}`, since: 0, error };
    this.takes.push({ name: take, dataset: name, seconds, megabytes: 0.07 * seconds, truth: false });
    let dataset = this.datasets.find((one) => one.name === name);
    if (!dataset) this.datasets.push((dataset = { name, performers: [] }));
    let known = dataset.performers.find((one) => one.name === performer);
    if (!known) dataset.performers.push((known = { name: performer, takes: 0, lines: 0 }));
    known.takes += 1;
    known.lines += this.session.prompts.well.size;
    this.session.event("recorded", `Take written: takes/${name}/${take}`);
  }
}
