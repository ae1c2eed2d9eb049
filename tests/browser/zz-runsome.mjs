for (const name of process.argv.slice(2)) await import(`/work/main/tests/browser/${name}.test.mjs`);
