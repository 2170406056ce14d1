// One clock for all that moves. It plays a scene's motion in some seconds, however fast the body really spins.

const clock = { part: 0.4, playing: false, seconds: 16, hands: [] };

// tick(part) is called whenever the time changes, and only while `holder` can be seen.
function follow_clock(holder, tick) {
  const hand = { tick, holder, seen: false };
  clock.hands.push(hand);
  new IntersectionObserver(([entry]) => {
    hand.seen = entry.isIntersecting;
    if (hand.seen) tick(clock.part);
  }).observe(holder);
}

function set_clock(part) {
  clock.part = part;
  clock.hands = clock.hands.filter((hand) => hand.holder.isConnected);
  for (const hand of clock.hands) if (hand.seen) hand.tick(part);
}

function play(on) {
  clock.playing = on;
  let before = null;
  const frame = (now) => {
    if (!clock.playing) return;
    if (before !== null) set_clock((clock.part + (now - before) / 1000 / clock.seconds) % 1);
    before = now;
    requestAnimationFrame(frame);
  };
  if (on) requestAnimationFrame(frame);
  for (const button of document.querySelectorAll(".play")) button.textContent = on ? "Pause" : "Play";
}

// Play and pause, and a slider along the time of the scene.
function clock_controls(section_id) {
  place(section_id, "controls clock", ["scene"], () => {
    if (!has_motion(state.scene)) return [];
    const { t } = motion_of(state.scene, truth_solver()), end = t[t.length - 1];
    const slider = el("input", { type: "range", min: "0", max: "1000", step: "1", value: 1000 * clock.part, "aria-label": "Time",
      on_input: (event) => {
        play(false);
        set_clock(event.target.value / 1000);
      } });
    const says = el("output", { class: "soft" });
    const show = (part) => {
      slider.value = 1000 * part;
      const [number, unit] = pretty_time(end).split("\u00a0");
      says.textContent = `t = ${(part * Number(number)).toPrecision(3)} of ${number} ${unit}`;
    };
    show(clock.part);
    follow_clock(slider, show);
    return [el("button", { type: "button", class: "play", on_click: () => play(!clock.playing) }, clock.playing ? "Pause" : "Play"),
      slider, says, el("small", { class: "soft" }, `${pretty_factor(Math.max(clock.seconds / end, end / clock.seconds))} times `
        + (end < clock.seconds ? "slower than life" : "faster than life"))];
  });
}
