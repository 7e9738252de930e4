// `envelope`: follows the peaks of curves: up at once, or as fast as `attack_s` says, and down as slowly as `release_s` says.
// With the time constant tau in seconds and f frames a second, each frame goes the share 1 - exp(-1 / (tau f)) of the way.
import { cabi_realloc, number, pair, port, stopped, take, text } from "./component";
export { cabi_realloc };

export function describe(): usize {
  const inputs = take(28), outputs = take(28), parameters = take(144), node = take(56), all = take(8);
  port(inputs, "curves", "Curves", "one value per channel and frame");
  port(outputs, "curves", "Curves", "the same channels and frames: the envelope of each");
  number(parameters, "attack_s", "Time constant of the way up; 0 follows at once.", 0.0, 0.0, 10.0);
  number(parameters + 72, "release_s", "Time constant of the way down.", 0.25, 0.0, 60.0);
  text(node, "envelope");
  text(node + 8, "Follows the peaks of curves: fast up, slowly down.");
  store<u32>(node, 1, 16);
  store<u8>(node, 0, 20); // It looks at all frames before, so it works whole.
  pair(node + 32, inputs, 1);
  pair(node + 40, outputs, 1);
  pair(node + 48, parameters, 2);
  pair(all, node, 1);
  return all;
}

function share(seconds: f64, rate: f64): f32 {
  return seconds <= 0 ? 1 : ((1 - Math.exp(-1 / (seconds * rate))) as f32);
}

// Parameters come in the order of their names, 24 bytes each with the number at 16. The one input is a standing of 16 bytes
// with its items at 8; the item's value is at 8, and its curves at 16: first frame, rate, count, channels at 40, values at 48.
export function evaluate(
  node: usize, nodeLength: u32, parameters: usize, parameterCount: u32, inputs: usize, inputCount: u32,
): usize {
  const item = load<u32>(inputs, 8) as usize;
  const rate = load<f64>(item, 24), frames = load<u32>(item, 32), channels = load<u32>(item, 44);
  const values = load<u32>(item, 48) as usize;
  const up = share(load<f64>(parameters, 16), rate), down = share(load<f64>(parameters, 40), rate);
  const answer = take(24), output = take(16);
  for (let t: u32 = 1; t < frames; t++) {
    if ((t & 1023) == 0 && stopped((t as f64) / (frames as f64))) {
      store<u8>(answer, 1);
      store<u8>(answer, 3, 4); // cancelled
      return answer;
    }
    const row = values + (t * channels) * 4;
    for (let c: u32 = 0; c < channels; c++) {
      const now = load<f32>(row + c * 4), last = load<f32>(row + c * 4 - channels * 4);
      store<f32>(row + c * 4, last + (now > last ? up : down) * (now - last));
    }
  }
  text(output, "curves");
  pair(output + 8, item, 1);
  pair(answer + 4, output, 1);
  return answer;
}
