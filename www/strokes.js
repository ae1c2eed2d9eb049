// Dabs of the brush on their way to the engine: in order, one at a time.

/** A queue up to this long is sent at the pace of the screen; a longer one as fast as the engine answers. */
const CROWD = 6;

const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));

/** Milliseconds without a dab after which a stroke is over. */
const REST_MS = 250;

/** `send(dab)` resolves when the engine has answered; `rested()` is called when a stroke is over. */
export function dabQueue(send, rested) {
  let waiting = [];
  /** The loop that sends; one that waits for a lost engine is left behind. */
  let turn = 0;
  let isSending = false;
  let rest = 0;

  async function work() {
    const mine = turn;
    isSending = true;
    while (waiting.length > 0) {
      await send(waiting.shift());
      if (mine === turn && waiting.length <= CROWD) await nextFrame();
      if (mine !== turn) return;
    }
    isSending = false;
    rest = setTimeout(rested, REST_MS);
  }

  return {
    add(dabs) {
      clearTimeout(rest);
      waiting.push(...dabs);
      if (!isSending) work();
    },
    /** Forgets what has not been sent: the engine that waits for it is gone, or its surface. */
    drop() {
      turn += 1;
      waiting = [];
      isSending = false;
    },
  };
}
