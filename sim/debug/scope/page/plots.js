// SPDX-License-Identifier: Apache-2.0
// Drawings of the scope: curves over time, step responses, the machine in space.
'use strict';

const COLOURS = ['#0072B2', '#D55E00', '#009E73', '#CC79A7', '#56B4E9', '#E69F00', '#1a1a1a', '#7a5c00'];
const LOOK = {
  template: {}, font: {family: 'system-ui, sans-serif', size: 12, color: '#1a1a1a'},
  paper_bgcolor: 'white', plot_bgcolor: 'white', hovermode: 'closest',
};
const AXIS = {gridcolor: '#ddd', linecolor: '#1a1a1a', zeroline: false, automargin: true, exponentformat: 'SI'};
const CONFIG = {responsive: true, displaylogo: false, displayModeBar: false, doubleClick: false};
const PANEL = 130;  // px

// One panel per unit, curves in the colour of their place in the list.
function drawCurves(div, frame, channels, period, cursors) {
  const names = Object.keys(frame.curves);
  const units = [...new Set(names.map(name => channels[name].unit))];
  const from = frame.at === null ? 0 : frame.at;
  const time = tick => (tick - from) * period;
  const gap = 0.04, high = (1 - gap * (units.length - 1)) / Math.max(units.length, 1);
  const layout = {
    ...LOOK, height: 70 + PANEL * units.length, margin: {l: 60, r: 10, t: 10, b: 40},
    showlegend: true, legend: {orientation: 'h', y: 1, yanchor: 'bottom', x: 0},
    xaxis: {...AXIS, title: {text: frame.at === null ? 'time [s]' : 'time since the trigger or fault [s]'},
            range: [time(frame.begin), time(Math.max(frame.end - 1, frame.begin + 1))],
            anchor: `y${units.length > 1 ? units.length : ''}`, exponentformat: 'none'},
    shapes: [], uirevision: 'kept',
  };
  units.forEach((unit, k) => {
    const top = 1 - k * (high + gap);
    layout[`yaxis${k ? k + 1 : ''}`] = {
      ...AXIS, title: {text: `[${unit || '1'}]`}, domain: [Math.max(top - high, 0), top], fixedrange: true,
    };
  });
  const line = (tick, colour, dash) => layout.shapes.push({
    type: 'line', xref: 'x', yref: 'paper', x0: time(tick), x1: time(tick), y0: 0, y1: 1,
    line: {color: colour, width: 1, dash},
  });
  if (frame.at !== null) line(frame.at, '#b00020', 'dash');
  cursors.forEach((tick, k) => tick !== null && line(tick, ['#444', '#888'][k], 'solid'));
  const traces = names.map((name, k) => ({
    x: frame.curves[name].t.map(time), y: frame.curves[name].v, name, mode: 'lines', type: 'scatter',
    yaxis: `y${units.indexOf(channels[name].unit) ? units.indexOf(channels[name].unit) + 1 : ''}`,
    line: {color: COLOURS[k % COLOURS.length], width: 1, shape: 'hv'}, connectgaps: false,
    hovertemplate: `${name} %{y}<br>%{x} s<extra></extra>`, customdata: frame.curves[name].t,
  }));
  return Plotly.react(div, traces, layout, CONFIG);
}

// The last step responses above each other, each by the size of its step.
function drawResponses(div, responses, period) {
  const traces = responses.map((r, k) => ({
    x: r.ticks.map(tick => tick * period), y: r.values.map(v => v / r.figures.amplitude),
    name: `${r.name}, gains ${r.version}`, mode: 'lines', type: 'scatter',
    line: {color: COLOURS[(responses.length - 1 - k) % COLOURS.length], width: k === responses.length - 1 ? 2 : 1},
  }));
  const level = y => ({type: 'line', xref: 'paper', x0: 0, x1: 1, y0: y, y1: y, line: {color: '#999', width: 1, dash: 'dot'}});
  return Plotly.react(div, traces, {
    ...LOOK, margin: {l: 45, r: 10, t: 10, b: 35}, showlegend: true, legend: {orientation: 'h', y: 1, yanchor: 'bottom'},
    xaxis: {...AXIS, title: {text: 'time since the step [s]'}}, yaxis: {...AXIS, title: {text: 'of the step'}},
    shapes: [level(0.1), level(0.9), level(1)],
  }, CONFIG);
}

// A point of the table in the machine: tilt about x through the pivot, after the turn about z.
function onTable(scene, radius, angle, tilt, turn) {
  const x = radius * Math.cos(angle + turn), y = radius * Math.sin(angle + turn), [px, py, pz] = scene.pivot;
  return [px + x, py + y * Math.cos(tilt) - scene.height * Math.sin(tilt),
          pz + y * Math.sin(tilt) + scene.height * Math.cos(tilt)];
}

function drawMachine(div, scene, space) {
  const line = (points, name, colour, width, more) => ({
    type: 'scatter3d', mode: 'lines', name, hoverinfo: 'name', x: points[0], y: points[1], z: points[2],
    line: {color: colour, width}, ...more,
  });
  const across = points => [0, 1, 2].map(k => points.map(p => p && p[k]));
  const tool = space ? space.now.slice(0, 3) : null;
  const traces = [line(scene.path, 'path', '#999', 2)];
  if (tool) {
    const [tilt, turn] = space.now.slice(3), reach = Math.hypot(...scene.legs[0]) / 4;
    const rim = [...Array(37).keys()].map(k => onTable(scene, reach, k * Math.PI / 18, tilt, turn));
    traces.push(line(space.trail, 'last ticks', '#D55E00', 5));
    traces.push(line(across(scene.legs.flatMap(leg => [leg, tool, null])), 'legs', '#0072B2', 7));
    traces.push(line(across([...rim, null, onTable(scene, 0, 0, tilt, turn), rim[0]]), 'table', '#009E73', 4));
    traces.push({type: 'scatter3d', mode: 'markers', name: 'tool', x: [tool[0]], y: [tool[1]], z: [tool[2]],
                 marker: {size: 5, color: '#1a1a1a'}});
  }
  const box = {title: {text: ''}, backgroundcolor: '#f7f7f7', showbackground: true, gridcolor: '#ccc'};
  return Plotly.react(div, traces, {
    ...LOOK, margin: {l: 0, r: 0, t: 0, b: 0}, showlegend: false, uirevision: 'kept',
    scene: {xaxis: box, yaxis: box, zaxis: box, aspectmode: 'data', camera: {eye: {x: 1.1, y: -1.9, z: 0.7}, projection: {type: 'orthographic'}}},
  }, CONFIG);
}
