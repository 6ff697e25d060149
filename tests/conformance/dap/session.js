// SPDX-License-Identifier: Apache-2.0
// Sessions of VS Code's own test client with a debug adapter. Prints a line of JSON for each check:
// {"check": text, "passed": boolean, "detail": text}.
//   node session.js ASIP_DBG LEG.s ENDLESS.s LOOP.s CORE    CORE: launch arguments in JSON
"use strict";
const assert = require("assert");
const cp = require("child_process");
const { DebugClient } = require("@vscode/debugadapter-testsupport");

const [adapter, leg, endless, loop, core] = process.argv.slice(2);
const TIMEOUT = 120000; // a guard against a hang
const INPUTS = { x: 0.3, y: 0.1, z: 0.2, l: 0.45 };
const LINE_11 = { path: leg, line: 11 };
const FAULT = { ...INPUTS, z: 0.7 };
const THREAD = { threadId: 1 };

const launchOf = (program, more) => ({ program, set: INPUTS, ...JSON.parse(core), ...more });
const source = (path) => ({ path });

async function refused(promise, text) {
  const answer = await promise.then(() => null, (error) => String(error.message || error));
  assert.ok(answer !== null, "the request was not refused");
  assert.ok(answer.includes(text), `'${answer}' does not contain '${text}'`);
}

// What a client does after `initialized`, before the program goes.
function launched(dc, args, configure) {
  const configured = dc.waitForEvent("initialized").then(configure);
  return Promise.all([
    dc.launch(args),
    configured.then(() => dc.configurationDoneRequest()),
    dc.waitForEvent("stopped").then((event) => event.body),
  ]).then((all) => all[2]);
}

async function go(dc, request) {
  const [stopped] = await Promise.all([dc.waitForEvent("stopped"), request]);
  return stopped.body;
}

async function top(dc) {
  return (await dc.stackTraceRequest(THREAD)).body.stackFrames[0];
}

async function scope(dc, name) {
  const { scopes } = (await dc.scopesRequest({ frameId: 1 })).body;
  const { variablesReference } = scopes.find((each) => each.name === name);
  const found = (await dc.variablesRequest({ variablesReference })).body.variables;
  return Object.fromEntries(found.map((each) => [each.name, each.value]));
}

const value = async (dc, expression, context = "watch") =>
  (await dc.evaluateRequest({ expression, context })).body.result;

const CHECKS = {
  "hitBreakpoint: a breakpoint at a line is verified there and stops there": (dc) =>
    dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 }),

  "hitBreakpoint: one at a line without code moves to the next line with code": (dc) =>
    dc.hitBreakpoint(launchOf(leg), { path: leg, line: 2 }, LINE_11, LINE_11),

  "setBreakpoints: a line beyond the end of the source is not verified": async (dc) => {
    const stopped = await launched(dc, launchOf(leg), async () => {
      const { breakpoints } = (
        await dc.setBreakpointsRequest({ source: source(leg), breakpoints: [{ line: 99 }] })
      ).body;
      assert.strictEqual(breakpoints[0].verified, false);
      assert.ok(breakpoints[0].message);
    });
    assert.strictEqual(stopped.reason, "end of tick");
  },

  "configurationSequence and assertStoppedLocation: stopOnEntry stops at the first line": (dc) =>
    Promise.all([
      dc.configurationSequence(),
      dc.launch(launchOf(leg, { stopOnEntry: true })),
      dc.assertStoppedLocation("entry", { path: leg, line: 11 }),
    ]),

  "stepping: next, stepIn, stepOut": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 });
    await Promise.all([
      dc.nextRequest(THREAD),
      dc.assertStoppedLocation("step", { path: leg, line: 17 }),
    ]);
    assert.strictEqual((await go(dc, dc.stepInRequest(THREAD))).reason, "step");
    assert.strictEqual((await go(dc, dc.stepOutRequest(THREAD))).reason, "end of tick");
  },

  "threads, scopes and variables": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 });
    assert.deepStrictEqual((await dc.threadsRequest()).body.threads, [{ id: 1, name: "core" }]);
    assert.strictEqual((await scope(dc, "Inputs")).x, "0.3");
    const values = await scope(dc, "Values");
    assert.strictEqual(values.t, "0.25");
    assert.match(values.e, /not yet computed/);
  },

  "setVariable: the value reads back, and the program uses it": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 17 });
    const { scopes } = (await dc.scopesRequest({ frameId: 1 })).body;
    const { variablesReference } = scopes.find((each) => each.name === "Values");
    const answer = await dc.setVariableRequest({ variablesReference, name: "e", value: "0.5" });
    assert.strictEqual(answer.body.value, "0.5");
    assert.strictEqual(await value(dc, "e"), "0.5");
    await go(dc, dc.stepOutRequest(THREAD));
    assert.strictEqual((await scope(dc, "Outputs")).F, "100");
  },

  "setVariable: a value shown in hexadecimal reads back": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 17 });
    const form = { format: { hex: true } };
    const ask = { expression: "e", context: "watch", ...form };
    const shown = (await dc.evaluateRequest(ask)).body.result;
    assert.match(shown, /^0x[0-9a-f]{8}$/);
    const { scopes } = (await dc.scopesRequest({ frameId: 1 })).body;
    const { variablesReference } = scopes.find((each) => each.name === "Values");
    await dc.setVariableRequest({ variablesReference, name: "e", value: shown, ...form });
    assert.strictEqual((await dc.evaluateRequest(ask)).body.result, shown);
  },

  "evaluate: watch, hover and console": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 });
    assert.strictEqual(await value(dc, "2*t"), "0.5");
    assert.strictEqual(await value(dc, "t", "hover"), "0.25");
    assert.match(await value(dc, "print t", "repl"), /t = 0\.25/);
    await refused(dc.evaluateRequest({ expression: "1 +", context: "watch" }), "not an expression");
  },

  "evaluate: an element of a table": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 });
    assert.strictEqual(await value(dc, "table[3]"), "8");
    await refused(dc.evaluateRequest({ expression: "table[9]", context: "watch" }), "0 to 3");
  },

  "condition, hit count and log point": async (dc) => {
    const lines = [];
    dc.on("output", (event) => lines.push(event.body.output));
    await launched(dc, launchOf(leg, { stopOnEntry: true }), () =>
      dc.setBreakpointsRequest({
        source: source(leg),
        breakpoints: [
          { line: 16, condition: "t > 1" },
          { line: 17, logMessage: "e is {e}" },
          { line: 18, hitCondition: "2" },
        ],
      })
    );
    const one = await go(dc, dc.continueRequest(THREAD));
    assert.strictEqual(one.reason, "end of tick");
    const two = await go(dc, dc.continueRequest(THREAD));
    assert.strictEqual(two.reason, "breakpoint");
    assert.strictEqual((await top(dc)).line, 17); // the bundle of lines 17 and 18
    assert.ok(lines.some((line) => line.startsWith("e is ")));
  },

  "condition: an error is reported where it is given": async (dc) => {
    await launched(dc, launchOf(leg, { stopOnEntry: true }), async () => {
      const { breakpoints } = (
        await dc.setBreakpointsRequest({
          source: source(leg),
          breakpoints: [{ line: 16, condition: "t > and" }],
        })
      ).body;
      assert.strictEqual(breakpoints[0].verified, false);
      assert.match(breakpoints[0].message, /not an expression/);
    });
  },

  "function breakpoint": async (dc) => {
    const stopped = await launched(dc, launchOf(leg), () =>
      dc.setFunctionBreakpointsRequest({ breakpoints: [{ name: "(29)" }] })
    );
    assert.strictEqual(stopped.reason, "breakpoint");
    assert.strictEqual((await top(dc)).line, 17);
  },

  "data breakpoint": async (dc) => {
    await launched(dc, launchOf(leg, { stopOnEntry: true }), () => undefined);
    const info = (await dc.dataBreakpointInfoRequest({ name: "e" })).body;
    assert.ok(info.dataId);
    await dc.setDataBreakpointsRequest({ breakpoints: [{ dataId: info.dataId }] });
    assert.strictEqual((await go(dc, dc.continueRequest(THREAD))).reason, "data breakpoint");
  },

  "instruction breakpoint and disassemble": async (dc) => {
    await launched(dc, launchOf(leg, { stopOnEntry: true }), () => undefined);
    const ask = { memoryReference: "0x0", instructionCount: 4 };
    const rows = (await dc.disassembleRequest(ask)).body.instructions;
    assert.strictEqual(rows.length, 4);
    await dc.customRequest("setInstructionBreakpoints", {
      breakpoints: [{ instructionReference: rows[2].address }],
    });
    await go(dc, dc.continueRequest(THREAD));
    assert.strictEqual((await top(dc)).instructionPointerReference, rows[2].address);
  },

  "exception: a fault stops, its text is on stderr and in exceptionInfo": async (dc) => {
    const output = dc.assertOutput("stderr", "NOT_FINITE", TIMEOUT);
    const stopped = await launched(dc, launchOf(leg, { set: FAULT }), () => undefined);
    assert.strictEqual(stopped.reason, "exception");
    await output;
    const info = (await dc.exceptionInfoRequest(THREAD)).body;
    assert.strictEqual(info.exceptionId, "NOT_FINITE");
  },

  "stack of macro calls": async (dc) => {
    await launched(dc, launchOf(loop, { set: { scale: 2.0 } }), () =>
      dc.setBreakpointsRequest({ source: source(loop), breakpoints: [{ line: 11 }] })
    );
    const { stackFrames, totalFrames } = (await dc.stackTraceRequest(THREAD)).body;
    assert.strictEqual(totalFrames, 2);
    assert.strictEqual(stackFrames[1].name, "macro add_entry");
  },

  "pause, and a breakpoint set while the program runs": async (dc) => {
    const ready = dc.waitForEvent("initialized").then(() => dc.configurationDoneRequest());
    await Promise.all([dc.launch(launchOf(endless, { set: {} })), ready]);
    assert.strictEqual((await go(dc, dc.pauseRequest(THREAD))).reason, "pause");
    await dc.continueRequest(THREAD);
    const breakpoints = [{ line: 8 }];
    const set = dc.setBreakpointsRequest({ source: source(endless), breakpoints });
    assert.strictEqual((await go(dc, set)).reason, "breakpoint");
  },

  "restart": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg, { stopOnEntry: false }), { path: leg, line: 16 });
    await Promise.all([
      dc.restartRequest({}),
      dc.assertStoppedLocation("breakpoint", { path: leg, line: 16 }),
    ]);
  },

  "completions, loadedSources and breakpointLocations": async (dc) => {
    await launched(dc, launchOf(leg, { stopOnEntry: true }), () => undefined);
    const { targets } = (await dc.completionsRequest({ text: "print l_", column: 9 })).body;
    assert.deepStrictEqual(targets, [{ label: "l_d", start: 6, length: 2 }]);
    const { sources } = (await dc.customRequest("loadedSources")).body;
    assert.strictEqual(sources[0].path, leg);
    const ask = { source: source(leg), line: 10, endLine: 12 };
    const { breakpoints } = (await dc.customRequest("breakpointLocations", ask)).body;
    assert.deepStrictEqual(breakpoints, [{ line: 11 }, { line: 12 }]);
  },

  "lines from 0: a client may count so": async (dc) => {
    const initialized = dc.waitForEvent("initialized");
    await dc.initializeRequest({ adapterID: "asip", linesStartAt1: false, pathFormat: "path" });
    await dc.launchRequest(launchOf(leg));
    await initialized;
    await dc.setBreakpointsRequest({ source: source(leg), breakpoints: [{ line: 15 }] });
    await Promise.all([
      dc.configurationDoneRequest(),
      dc.assertStoppedLocation("breakpoint", { path: leg, line: 15 }),
    ]);
    assert.match((await top(dc)).name, /\(28\)/);
  },

  "refusals: requests that are not advertised": async (dc) => {
    await launched(dc, launchOf(leg, { stopOnEntry: true }), () => undefined);
    await refused(dc.stepBackRequest(THREAD), "stepBack");
    await refused(dc.reverseContinueRequest(THREAD), "reverseContinue");
    await refused(dc.gotoRequest({ threadId: 1, targetId: 1 }), "goto");
    await refused(dc.restartFrameRequest({ frameId: 1 }), "restartFrame");
    await refused(dc.modulesRequest({}), "modules");
    await refused(dc.stepInTargetsRequest({ frameId: 1 }), "stepInTargets");
    await refused(dc.gotoTargetsRequest({ source: source(leg), line: 11 }), "gotoTargets");
    await refused(dc.sourceRequest({ sourceReference: 1 }), "source");
  },

  "refusals: a program that does not exist": async (dc) => {
    await dc.initializeRequest();
    await refused(dc.launchRequest(launchOf("/nowhere/none.s")), "none.s");
  },

  "terminate: the event follows": async (dc) => {
    await dc.hitBreakpoint(launchOf(leg), { path: leg, line: 16 });
    await Promise.all([dc.waitForEvent("terminated"), dc.terminateRequest({})]);
  },

  "server on a port": async () => {
    const server = cp.spawn(adapter, ["--dap", "--port", "0"]);
    try {
      const said = await new Promise((resolve) => {
        let text = "";
        server.stderr.on("data", (data) => {
          text += data;
          if (/127\.0\.0\.1:\d+/.test(text) && /token/.test(text)) resolve(text);
        });
      });
      const port = Number(/127\.0\.0\.1:(\d+)/.exec(said)[1]);
      const token = /"token": *"([^"]+)"/.exec(said)[1];
      const dc = new DebugClient("none", "none", "asip");
      await dc.start(port);
      // The server closes a connection without the token; a disconnect would have no answer.
      await refused(dc.initializeRequest().then(() => dc.launchRequest(launchOf(leg))), "token");
      const next = new DebugClient("none", "none", "asip");
      await next.start(port);
      await next.hitBreakpoint(launchOf(leg, { token }), { path: leg, line: 16 });
      await next.stop();
    } finally {
      server.kill();
    }
  },
};

function within(milliseconds, promise, text) {
  let timer;
  const late = new Promise((_, reject) => {
    timer = setTimeout(() => reject(new Error(text)), milliseconds);
  });
  return Promise.race([promise, late]).finally(() => clearTimeout(timer));
}

async function main() {
  for (const [check, run] of Object.entries(CHECKS)) {
    const dc = new DebugClient(adapter, "--dap", "asip", undefined, true);
    dc.defaultTimeout = TIMEOUT;
    let detail = "";
    try {
      if (run.length) await dc.start();
      await within(TIMEOUT, run(dc), "no end");
    } catch (error) {
      detail = String(error.message || error);
    }
    if (run.length) {
      await within(TIMEOUT, dc.stop(), "disconnect is not answered").catch((error) => {
        detail = detail || error.message;
      });
    }
    console.log(JSON.stringify({ check, passed: detail === "", detail }));
  }
}

main().then(() => process.exit(0));
