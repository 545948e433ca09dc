/** Prompts aloud, by a voice of this machine: what a performer is asked for goes to nobody else's. */

/** The browser's voice; undefined where it has none of this machine's, or has not found it yet. */
export function findVoice(): SpeechSynthesisVoice | undefined {
  return window.speechSynthesis?.getVoices().find((one) => one.localService && one.lang.startsWith("en"));
}

/** Says it, instead of what was being said; nothing where there is no voice. */
export function speak(text: string): void {
  const voice = findVoice();
  if (!voice) return;
  const words = new SpeechSynthesisUtterance(text);
  words.voice = voice;
  words.lang = voice.lang;
  window.speechSynthesis.cancel();
  window.speechSynthesis.speak(words);
}
