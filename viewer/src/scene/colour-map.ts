// Colours for a quantity: pressure from blue to yellow, weights from blue to red.

type Stop = readonly [number, number, number];

/** Blue, violet, rose, orange, yellow: lighter all the way, and apart from skin, glass and grey at its
 * dark end (after matplotlib's plasma, from its middle blue on). */
export const STOPS: readonly Stop[] = [
  [0.19, 0.19, 0.75],
  [0.42, 0.09, 0.78],
  [0.65, 0.13, 0.65],
  [0.82, 0.28, 0.47],
  [0.93, 0.45, 0.33],
  [0.99, 0.65, 0.2],
  [0.98, 0.82, 0.15],
  [0.97, 0.97, 0.35],
];

/** For weights: blue none, red all, pale between (after Moreland's cool-warm). */
export const WEIGHT_STOPS: readonly Stop[] = [
  [0.1, 0.24, 0.72],
  [0.4, 0.58, 0.93],
  [0.87, 0.87, 0.87],
  [0.94, 0.52, 0.4],
  [0.72, 0.05, 0.12],
];

export function cssGradient(stops: readonly Stop[]): string {
  const colours = stops.map((stop) => `rgb(${stop.map((c) => Math.round(255 * c)).join(" ")})`);
  return `linear-gradient(to right, ${colours.join(", ")})`;
}

/** A map as a GLSL function of a number from 0 to 1, linear light out. */
const glslMap = (name: string, map: readonly Stop[]) => /* glsl */ `
vec3 ${name}( float x ) {
  vec3 stops[ ${map.length} ] = vec3[](
    ${map.map((s) => `vec3( ${s.map((c) => c.toFixed(3)).join(", ")} )`).join(",\n    ")} );
  float at = clamp( x, 0.0, 1.0 ) * ${(map.length - 1).toFixed(1)};
  int i = min( int( at ), ${map.length - 2} );
  return pow( mix( stops[ i ], stops[ i + 1 ], at - float( i ) ), vec3( 2.2 ) );
}
`;

export const COLOUR_MAPS = glslMap("colourMap", STOPS) + glslMap("weightMap", WEIGHT_STOPS);

/** The next number of 1, 2, 5 × 10^k not below `x`. */
export function roundUp(x: number): number {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  for (const step of [1, 2, 5, 10]) if (x <= step * power * (1 + 1e-9)) return step * power;
  return 10 * power;
}
