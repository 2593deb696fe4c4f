// Asks for what was felt until now, again and again, and for the whole page when the run has ended.
"use strict";

const ASK_AGAIN = 400;

async function follow() {
  const stand = document.getElementById("stand");
  let number = "";
  for (;;) {
    try {
      const answer = await (await fetch(`now?after=${number}`)).json();
      stand.textContent = answer.stand;
      number = answer.number;
      if (answer.data) window.palpate.adopt(unpack(answer.data));
      if (answer.done) return location.reload();
    } catch {
      stand.textContent = "The run is no longer served.";
      return;
    }
    await new Promise((done) => setTimeout(done, ASK_AGAIN));
  }
}

follow();
