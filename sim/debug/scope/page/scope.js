// SPDX-License-Identifier: Apache-2.0
// The page of the scope: its link to the server, and what is done with what comes.
'use strict';

const RETRY = 2000;  // ms until the next try to connect
// Drawing takes at most a third of the time, the machine in space a tenth, however slow the browser.
const REST = 2, MACHINE_REST = 10;
let socket, source, channels = {}, state = null, chosen = [], cursors = [null, null];
let zoom = {begin: null, end: null}, part = 'live', faultSeen = null;
let drawn = 0, machineNext = 0, answered = '', ticks = [], lastFrame = null;

function say(message) { if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message)); }

function connect() {
  socket = new WebSocket(new URL('ws', location.href.replace(/^http/, 'ws')));
  socket.onmessage = event => receive(JSON.parse(event.data));
  socket.onclose = () => {
    tellStatus('no connection', '');
    setTimeout(connect, RETRY);
  };
}

function receive(message) {
  const handlers = {hello, frame, state: showState, blackbox: showLastTicks, error, cursor};
  handlers[message.type](message);
}

function cursor(reply) { showCursors(reply, source.period, channels); }

function error(message) {
  $('message').textContent = message.text;
  $('message').hidden = false;
}

function tellStatus(text, kind) {
  $('status').textContent = text;
  $('status').className = `pill ${kind}`;
}

function hello(message) {
  source = message.source;
  channels = Object.fromEntries(source.channels.map(channel => [channel.name, channel]));
  if (!chosen.length) chosen = [...source.shown];
  document.title = $('title').textContent = source.title;
  buildChannels(source.channels, chosen, choose);
  buildGains(source.gains, (name, value) => { clear(); say({type: 'stage', name, value}); });
  options($('trigger').elements.channel, Object.keys(channels));
  options($('step-input'), source.steps.map(step => step.name));
  options($('put-input'), source.inputs);
  stepChosen();
  $('simulation').hidden = !source.inputs.length;
  $('step').hidden = !source.steps.length;
  options($('measure-channel'), Object.keys(channels), chosen[0]);
  $('machine').hidden = !source.scene;
  $('pause').hidden = !source.paces;
  $('rate').parentElement.hidden = !source.paces;
  look();
}

function look() {
  say({type: 'view', channels: chosen, pixels: Math.max(Math.min($('curves').clientWidth, 4000), 50), ...zoom, part});
}

function choose(name, on) {
  chosen = on ? [...chosen, name] : chosen.filter(other => other !== name);
  look();
}

function clear() { $('message').hidden = true; }

async function frame(message) {
  const begin = performance.now();
  lastFrame = message;
  await drawCurves($('curves'), message, channels, source.period, cursors);
  $('kind').textContent = {
    live: 'latest ticks', window: 'ticks looked at', waiting: 'waiting for the trigger',
    capture: `triggered at tick ${message.at}`, blackbox: `before the fault in tick ${message.at}`,
  }[message.kind];
  if (!drawn++) listen();
  const now = performance.now();
  if (source.scene && now > machineNext) {
    await drawMachine($('robot'), source.scene, message.space);
    await painted();
    machineNext = performance.now() + MACHINE_REST * (performance.now() - now);
  }
  await painted();
  setTimeout(() => say({type: 'ready'}), REST * (now - begin));
}

const painted = () => new Promise(done => requestAnimationFrame(done));

function showState(message) {
  state = message;
  ticks.push([performance.now(), state.tick]);
  if (ticks.length > 20) ticks.shift();
  const [[from, first], [to, last]] = [ticks[0], ticks[ticks.length - 1]];
  const speed = to > from && !state.paused && !state.ended ? (last - first) / (to - from) * 1e3 : 0;
  const [text, kind] = state.fault ? ['fault', 'fault'] : state.ended ? [state.ended, '']
    : state.note ? ['no answer', 'paused'] : state.paused ? ['paused', 'paused'] : ['running', 'running'];
  tellStatus(text, kind);
  $('clock').textContent = `tick ${state.tick}${source.ticks ? ` of ${source.ticks}` : ''}, `
    + `${(state.tick * source.period).toFixed(3)} s; ${Math.round(speed)} ticks/s; `
    + `${state.kept} of ${state.length} kept` + (state.lost ? `, ${state.lost} lost` : '');
  if (state.note) error({text: state.note});
  $('pause').textContent = state.paused ? 'Run' : 'Pause';
  document.querySelector('#step button').disabled = state.stepping;
  showGains(state);
  showTrigger($('trigger'), state);
  const answers = JSON.stringify(state.responses);
  if (answers !== answered) {
    answered = answers;
    showFigures(state.responses);
    drawResponses($('responses'), state.responses, source.period);
  }
  $('fault').hidden = $('show-blackbox').hidden = !state.fault;
  if (state.fault && faultSeen !== state.fault.tick) {
    faultSeen = state.fault.tick;
    $('fault-text').textContent = `tick ${state.fault.tick}: ${state.fault.text}`;
    part = 'blackbox';
    look();
  }
}

// Events of the plot; there is something to listen to once it has been drawn.
function listen() {
  const tick = x => Math.round(x / source.period) + (lastFrame.at ?? 0);
  $('curves').on('plotly_relayout', change => {
    if (change['xaxis.range[0]'] === undefined) return;
    const [a, b] = [change['xaxis.range[0]'], change['xaxis.range[1]']].map(tick);
    zoom = {begin: Math.max(Math.min(a, b), 0), end: Math.max(a, b, 0) + 1};
    look();
  });
  $('curves').on('plotly_doubleclick', live);
  $('curves').on('plotly_click', data => {
    cursors[data.event.shiftKey ? 1 : 0] = data.points[0].customdata;
    const [a, b] = [cursors[0] ?? cursors[1], cursors[1] ?? cursors[0]];
    say({type: 'cursor', a, b});
    look();
  });
}

function live() {
  zoom = {begin: null, end: null};
  part = 'live';
  look();
}

function stepChosen() {
  const step = source.steps.find(step => step.name === $('step-input').value);
  if (!step) return;
  $('step-size').value = step.amplitude;
  $('step-unit').textContent = step.unit;
}

function pace(paused) {
  const factor = $('rate').value;
  clear();
  say({type: 'pace', paused, rate: factor ? Number(factor) / source.period : null});
}

function submit(form, action) {
  $(form).addEventListener('submit', event => {
    event.preventDefault();
    clear();
    action();
  });
}

async function picture() {
  const height = $('curves').offsetHeight, width = $('curves').offsetWidth;
  const link = document.createElement('a');
  link.href = await Plotly.toImage($('curves'), {format: 'png', width, height, scale: 2});
  link.download = 'asip-scope.png';
  link.click();
  return link.href;
}

function linkExports() {
  for (const kind of ['csv', 'parquet', 'mcap']) $(kind).href = `export/${$('part').value}.${kind}`;
}

$('pause').addEventListener('click', () => pace(!state.paused));
$('rate').addEventListener('change', () => pace(state.paused));
$('live').addEventListener('click', live);
$('show-blackbox').addEventListener('click', () => { part = 'blackbox'; zoom = {begin: null, end: null}; look(); });
$('part').addEventListener('change', linkExports);
$('png').addEventListener('click', picture);
$('arm').addEventListener('click', () => { clear(); say({type: 'arm'}); });
$('commit').addEventListener('click', () => { clear(); say({type: 'commit'}); });
$('discard').addEventListener('click', () => {
  for (const name of Object.keys(state.staged)) say({type: 'stage', name, value: null});
});
$('step-input').addEventListener('change', stepChosen);
$('trigger').elements.kind.addEventListener('change', () => fitTrigger($('trigger')));
submit('trigger', () => say({type: 'trigger', settings: triggerSettings($('trigger'))}));
submit('step', () => say({type: 'step', name: $('step-input').value, amplitude: Number($('step-size').value),
                          ticks: Math.round(Number($('step-ticks').value))}));
submit('measure', () => say({type: 'measure', channel: $('measure-channel').value}));
submit('put', () => say({type: 'put', name: $('put-input').value, value: null}));
window.addEventListener('resize', () => source && look());
linkExports();
connect();
