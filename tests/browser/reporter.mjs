// A line for each test and a plain count at the end.

/** What Node says at the end by itself. */
const COUNTS = /^(tests|suites|pass|fail|cancelled|skipped|todo|duration_ms) /;

export default async function* reporter(source) {
  const count = { passed: 0, failed: 0, skipped: 0 };
  for await (const { type, data } of source) {
    const indent = "  ".repeat(data?.nesting ?? 0);
    const isSuite = data?.details?.type === "suite";
    switch (type) {
      case "test:start":
        // All that stands at the top is a suite.
        if (data.nesting === 0) yield `${data.name}\n`;
        break;
      case "test:pass":
        if (isSuite) break;
        count[data.skip === undefined ? "passed" : "skipped"] += 1;
        yield `${indent}${data.skip === undefined ? "ok  " : "skip"}  ${data.name}  (${seconds(data)})${reason(data.skip)}\n`;
        break;
      case "test:fail":
        // A suite fails by itself only where its set-up did; otherwise its tests have said so.
        if (isSuite && data.details.error.failureType === "subtestsFailed") break;
        count.failed += 1;
        yield `${indent}FAIL  ${data.name}  (${seconds(data)})\n${explanation(data.details.error, indent)}`;
        break;
      case "test:diagnostic":
        if (data.nesting > 0) yield `${indent}      ${data.message}\n`;
        else if (!COUNTS.test(data.message)) {
          // An error that belongs to no test ends the process with a failure all the same.
          count.failed += 1;
          yield `FAIL  outside of a test\n      ${data.message}\n`;
        }
        break;
      case "test:stdout":
      case "test:stderr":
        yield data.message;
        break;
    }
  }
  const skipped = count.skipped > 0 ? `, ${count.skipped} skipped` : "";
  yield `\nbrowser: ${count.passed} passed, ${count.failed} failed${skipped}\n`;
}

const seconds = ({ details }) => `${(details.duration_ms / 1000).toFixed(1)} s`;
const reason = (skip) => (typeof skip === "string" ? `: ${skip}` : "");

function explanation(error, indent) {
  const cause = error.cause ?? error;
  const text = String(cause.stack ?? cause.message ?? cause);
  const lines = text.split("\n").filter((line) => !/^\s+at .*node:internal/.test(line));
  return lines.map((line) => `${indent}      ${line}\n`).join("");
}
