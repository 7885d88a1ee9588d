// While the study runs: how far it is, and the page again when there is more to see.
"use strict";
(() => {
  const bar = document.createElement("div");
  bar.className = "live-bar";
  bar.setAttribute("role", "status");
  document.body.prepend(bar);
  let first = null;
  const look = async () => {
    let state;
    try {
      state = await (await fetch("state")).json();
    } catch {
      bar.textContent = "the run is over, or can't be reached: this page stays as it is";
      return;
    }
    first = first === null ? state.settled : first;
    const running = state.running.map((r) => `${r.node}${r.percent ? `, ${r.percent} %` : ""}`);
    const failed = state.failed ? `, ${state.failed} failed` : "";
    const doing = running.length > 3 ? `${running.slice(0, 3).join("; ")} and ${running.length - 3} more` : running.join("; ");
    bar.textContent = state.ended ? `done: ${state.settled} of ${state.of}${failed}` : `${state.settled} of ${state.of} done${failed}${doing ? "; at work: " + doing : ""}`;
    // Not while someone is reading a number or steering a plot.
    const busy = document.querySelector("dialog[open]") || (document.activeElement && document.activeElement.closest(".plot"));
    if (state.settled > first && !busy) {
      location.reload();
      return;
    }
    if (!state.ended) setTimeout(look, 2000);
  };
  look();
})();
