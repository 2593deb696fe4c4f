// What WebGL draws here: lit triangles, round points, and lines of any width.
"use strict";

const MESH = {
  vertex: `#version 300 es
    in vec3 position; in vec3 normal; in vec3 color; in float face;
    uniform mat4 clip; uniform mat4 place; uniform float marked;
    out vec3 n; out vec3 c; out vec3 p;
    void main() {
      vec4 world = place * vec4(position, 1.0);
      n = mat3(place) * normal; p = world.xyz;
      c = (marked >= 0.0 && abs(face - marked) < 0.5) ? mix(color, vec3(1.0), 0.45) : color;
      gl_Position = clip * world;
    }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 n; in vec3 c; in vec3 p;
    uniform vec3 eye; uniform float alpha; uniform float lit;
    out vec4 pixel;
    void main() {
      vec3 v = normalize(eye - p);
      vec3 m = normalize(n); m *= sign(dot(m, v) + 1e-6);
      vec3 key = normalize(v + vec3(0.35, -0.25, 0.75));
      float light = mix(1.0, 0.58 + 0.14 * (m.z * 0.5 + 0.5) + 0.44 * pow(max(dot(m, key), 0.0), 1.4), lit);
      pixel = vec4(c * light, 1.0) * alpha;
    }`,
};

const LINE = {
  vertex: `#version 300 es
    in vec3 position; in vec3 other; in vec2 corner;
    uniform mat4 clip; uniform mat4 place; uniform vec2 view; uniform float width;
    void main() {
      vec4 a = clip * place * vec4(position, 1.0), b = clip * place * vec4(other, 1.0);
      vec2 along = (b.xy / b.w - a.xy / a.w) * view;
      vec2 across = length(along) > 1e-6 ? normalize(vec2(-along.y, along.x)) : vec2(0.0);
      a.xy += across * corner.x * corner.y * width / view * a.w;
      a.z -= 0.0012 * a.w;
      gl_Position = a;
    }`,
  fragment: `#version 300 es
    precision highp float;
    uniform vec4 ink; out vec4 pixel;
    void main() { pixel = vec4(ink.rgb, 1.0) * ink.a; }`,
};

const POINT = {
  vertex: `#version 300 es
    in vec3 position; in vec3 color;
    uniform mat4 clip; uniform float size; out vec3 c;
    void main() { gl_Position = clip * vec4(position, 1.0); gl_Position.z -= 0.0009 * gl_Position.w;
      gl_PointSize = size; c = color; }`,
  fragment: `#version 300 es
    precision highp float;
    in vec3 c; out vec4 pixel;
    void main() {
      float r = 2.0 * length(gl_PointCoord - 0.5);
      if (r > 1.0) discard;
      pixel = vec4(c * (r > 0.72 ? 0.7 : 1.0), 1.0);
    }`,
};

class Program {
  constructor(gl, source) {
    this.gl = gl;
    this.handle = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, source.vertex], [gl.FRAGMENT_SHADER, source.fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(this.handle, shader);
    }
    gl.linkProgram(this.handle);
    this.places = {};
  }

  set(name, value) {
    const gl = this.gl;
    if (!(name in this.places)) this.places[name] = gl.getUniformLocation(this.handle, name);
    const at = this.places[name];
    if (typeof value === "number") gl.uniform1f(at, value);
    else if (value.length === 16) gl.uniformMatrix4fv(at, false, value);
    else gl["uniform" + value.length + "fv"](at, value);
  }

  // columns: {attribute: [array, width]}
  table(columns, count) {
    const gl = this.gl, vertexArray = gl.createVertexArray(), buffers = {};
    gl.bindVertexArray(vertexArray);
    for (const [name, [values, width]] of Object.entries(columns)) {
      const at = gl.getAttribLocation(this.handle, name);
      if (at < 0) continue;
      buffers[name] = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[name]);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, width, gl.FLOAT, false, 0, 0);
    }
    gl.bindVertexArray(null);
    return { vertexArray, buffers, count };
  }

  draw(table, mode, uniforms, count = table && table.count) {
    if (!table || !count) return;
    const gl = this.gl;
    gl.useProgram(this.handle);
    for (const [name, value] of Object.entries(uniforms)) this.set(name, value);
    gl.bindVertexArray(table.vertexArray);
    gl.drawArrays(mode, 0, count);
    gl.bindVertexArray(null);
  }
}

// Segments (pairs of points, flat) as two triangles each.
function segmentColumns(points) {
  const n = points.length / 6, position = new Float32Array(n * 18), other = new Float32Array(n * 18);
  const corner = new Float32Array(n * 12);
  const order = [[0, 1], [0, -1], [1, 1], [1, 1], [0, -1], [1, -1]];
  for (let i = 0; i < n; i++) {
    order.forEach(([end, side], k) => {
      for (let axis = 0; axis < 3; axis++) {
        position[i * 18 + k * 3 + axis] = points[i * 6 + end * 3 + axis];
        other[i * 18 + k * 3 + axis] = points[i * 6 + (1 - end) * 3 + axis];
      }
      corner[i * 12 + k * 2] = end ? -1 : 1;
      corner[i * 12 + k * 2 + 1] = side;
    });
  }
  return [{ position: [position, 3], other: [other, 3], corner: [corner, 2] }, n * 6];
}

const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++)
    for (let k = 0; k < 4; k++) out[c * 4 + r] += a[k * 4 + r] * b[c * 4 + k];
  return out;
}

function perspective(fieldOfView, aspect, near, far) {
  const f = 1 / Math.tan(fieldOfView / 2), d = 1 / (near - far);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) * d, -1, 0, 0, 2 * far * near * d, 0]);
}
