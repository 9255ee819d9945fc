// Materials of deformable and rigid bodies, of the ground and of ghosts.

import {
  Color,
  DoubleSide,
  LineBasicMaterial,
  MeshBasicMaterial,
  MeshDepthMaterial,
  MeshStandardMaterial,
  ShaderChunk,
  type IUniform,
  type Material,
  type Texture,
  type Vector3,
  type WebGLProgramParametersWithUniforms,
} from "three";
import { COLOUR_MAPS } from "./colour-map";
import {
  EMBED_NORMAL,
  EMBED_PARS,
  EMBED_POSITION,
  NOISE,
  OCCLUSION_FRAGMENT,
  OCCLUSION_PARS,
  OCCLUSION_VERTEX,
  OCCLUSION_VERTEX_PARS,
  SKIN_LIGHT,
} from "./glsl";
import { after, before, replaceFragment, replaceOnce, replaceVertex } from "./shader-patch";
import type { Quality } from "./quality";
import { HAND_SPHERES, SPHERES } from "./occluders";

/** What all materials of a stage share. */
export interface Shared {
  readonly quality: Quality;
  readonly occluders: IUniform;
  readonly sceneFromWorld: IUniform;
  /** 1 while pressure shows. */
  readonly pressureShown: IUniform<number>;
  /** End of the pressure scale, Pa. */
  readonly pressureMost: IUniform<number>;
  /** 1 while skinning weights show. */
  readonly weightsShown: IUniform<number>;
}

type Shader = WebGLProgramParametersWithUniforms;

/** Wider, smoother shadows than three's five taps. */
export function smoothShadows(taps: number): void {
  const from =
    /shadow = \(\s*texture\( shadowMap, vec3\( shadowCoord\.xy \+ vogelDiskSample\( 0, 5, phi \)[\s\S]*?\) \* 0\.2;/;
  const to = `shadow = 0.0;
    for ( int i = 0; i < ${taps}; i ++ ) shadow += texture( shadowMap, vec3( shadowCoord.xy + vogelDiskSample( i, ${taps}, phi ) * radius, shadowCoord.z ) );
    shadow /= ${taps.toFixed(1)};`;
  if (from.test(ShaderChunk.shadowmap_pars_fragment)) {
    ShaderChunk.shadowmap_pars_fragment = replaceOnce(ShaderChunk.shadowmap_pars_fragment, from, to);
  }
}

/** `inset`: how far inside its own surface it is drawn, m. */
function embed(shader: Shader, nodes: IUniform<Texture>, inset = 0): void {
  shader.uniforms["nodeTexture"] = nodes;
  replaceVertex(shader, "#include <common>", after("#include <common>", EMBED_PARS));
  const position = inset === 0 ? EMBED_POSITION : after(EMBED_POSITION, insetBy(inset));
  replaceVertex(shader, "#include <begin_vertex>", position);
}

const insetBy = (inset: number) => `{ ${EMBED_NORMAL} transformed -= objectNormal * ${inset.toFixed(6)}; }`;

/** Who casts occlusion on a material. */
type OccludedBy = "hands" | "others" | "all" | "none";

function occlude(shader: Shader, shared: Shared, by: OccludedBy): void {
  if (by === "none" || !shared.quality.occlusion) return;
  shader.uniforms["occluders"] = shared.occluders;
  shader.uniforms["sceneFromWorld"] = shared.sceneFromWorld;
  const [from, to] = [by === "others" ? HAND_SPHERES : 0, by === "hands" ? HAND_SPHERES : SPHERES];
  const defines = `#define OCCLUDERS ${SPHERES}\n#define OCCLUDERS_FROM ${from}\n#define OCCLUDERS_TO ${to}\n`;
  replaceVertex(shader, "#include <common>", after("#include <common>", defines + OCCLUSION_VERTEX_PARS));
  replaceVertex(shader, "#include <worldpos_vertex>", after("#include <worldpos_vertex>", OCCLUSION_VERTEX));
  replaceFragment(shader, "#include <common>", after("#include <common>", defines + OCCLUSION_PARS));
  replaceFragment(
    shader,
    "#include <aomap_fragment>",
    after("#include <aomap_fragment>", OCCLUSION_FRAGMENT),
  );
}

function passRest(shader: Shader): void {
  replaceVertex(shader, "#include <common>", after("#include <common>", "varying vec3 vRest;"));
  replaceVertex(shader, "#include <project_vertex>", after("#include <project_vertex>", "vRest = position;"));
  replaceFragment(shader, "#include <common>", after("#include <common>", `varying vec3 vRest;\n${NOISE}`));
}

export function skinMaterial(colour: Color, nodes: IUniform<Texture>, shared: Shared): MeshStandardMaterial {
  const material = new MeshStandardMaterial({ color: colour, roughness: 0.56 });
  const detail = shared.quality.detail;
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes);
    replaceVertex(shader, "#include <beginnormal_vertex>", EMBED_NORMAL);
    passRest(shader);
    occlude(shader, shared, "others");
    shader.uniforms["pressureShown"] = shared.pressureShown;
    shader.uniforms["pressureMost"] = shared.pressureMost;
    shader.uniforms["weightsShown"] = shared.weightsShown;
    replaceVertex(
      shader,
      "#include <common>",
      after(
        "#include <common>",
        "attribute vec4 site; attribute float curve; attribute float pressure; attribute float boneWeight;\nvarying vec4 vSite; varying float vCurve; varying float vPressure; varying float vBoneWeight;",
      ),
    );
    replaceVertex(
      shader,
      "#include <project_vertex>",
      after("#include <project_vertex>", "vSite = site; vCurve = curve; vPressure = pressure; vBoneWeight = boneWeight;"),
    );
    replaceFragment(
      shader,
      "#include <common>",
      after(
        "#include <common>",
        `varying vec4 vSite; varying float vCurve; varying float vPressure; varying float vBoneWeight;
        uniform float pressureShown; uniform float pressureMost; uniform float weightsShown;
        vec3 smoothNormal; float scatter;\n${COLOUR_MAPS}`,
      ),
    );
    replaceFragment(
      shader,
      "#include <lights_physical_pars_fragment>",
      after("#include <lights_physical_pars_fragment>", SKIN_LIGHT),
    );
    // Nails, blood under the skin, creases.
    replaceFragment(
      shader,
      "#include <color_fragment>",
      after(
        "#include <color_fragment>",
        `float nailRadius = length( vec2( pow( abs( vSite.z ), 1.0 ), vSite.w * ( vSite.w > 0.0 ? 1.0 : 1.05 ) ) );
        float nailEdge = max( fwidth( nailRadius ), 0.015 );
        float nail = 1.0 - smoothstep( 1.0 - nailEdge, 1.0 + nailEdge, nailRadius );
        float groove = smoothstep( 0.16, 0.0, abs( nailRadius - 1.04 ) );
        float freeEdge = nail * smoothstep( 0.62, 0.72, vSite.w );
        float lunula = nail * ( 1.0 - smoothstep( 0.40, 0.52, length( vec2( vSite.z, ( vSite.w + 1.0 ) * 1.3 ) ) ) );
        float blood = vSite.x;
        ${detail ? "blood += 0.45 * ( noise3( vRest * 140.0 ) - 0.5 ) + 0.30 * ( noise3( vRest * 420.0 ) - 0.5 );" : ""}
        vec3 skin = diffuseColor.rgb;
        skin *= mix( vec3( 1.035, 1.02, 0.985 ), vec3( 1.03, 0.76, 0.70 ), clamp( blood, 0.0, 1.0 ) );
        skin *= mix( vec3( 0.62, 0.42, 0.36 ), vec3( 1.0 ), vSite.y );
        skin *= mix( vec3( 1.0 ), vec3( 0.86, 0.70, 0.66 ), groove );
        vec3 plate = diffuseColor.rgb * vec3( 1.10, 0.93, 0.93 );
        plate = mix( plate, vec3( 0.80, 0.68, 0.58 ), 0.6 * freeEdge + 0.35 * lunula );
        diffuseColor.rgb = mix( skin, plate, nail );
        diffuseColor.rgb = mix( diffuseColor.rgb, vec3( 0.55, 0.60, 0.66 ) * mix( 0.75, 1.0, vSite.y ), pressureShown );`,
      ),
    );
    replaceFragment(
      shader,
      "#include <roughnessmap_fragment>",
      after(
        "#include <roughnessmap_fragment>",
        `${detail ? "roughnessFactor += 0.16 * ( noise3( vRest * 900.0 ) - 0.5 ) * seen( vRest, 1.0 / 900.0 );" : ""}
        roughnessFactor = mix( roughnessFactor, 0.24, nail * ( 1.0 - 0.5 * freeEdge ) );`,
      ),
    );
    replaceFragment(
      shader,
      "#include <normal_fragment_maps>",
      after(
        "#include <normal_fragment_maps>",
        `smoothNormal = normal;
        scatter = clamp( 0.35 + vCurve / 160.0, 0.25, 1.25 ) * ( 1.0 - 0.6 * nail );
        ${
          detail
            ? `float relief = 34e-6 * noise3( vRest * 1100.0 ) * seen( vRest, 1.0 / 1100.0 )
          + 60e-6 * noise3( vRest * vec3( 420.0, 420.0, 420.0 ) ) * seen( vRest, 1.0 / 420.0 );
        relief *= 1.0 - 0.93 * nail;
        normal = bumped( - vViewPosition, normal, relief );`
            : ""
        }`,
      ),
    );
    // The shadow's share must be known apart from the light's colour.
    const lights = replaceOnce(
      ShaderChunk.lights_fragment_begin,
      "directLight.color *= ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap",
      "keyShadow = ( directLight.visible && receiveShadow ) ? getShadow( directionalShadowMap",
    ).replace(
      "getDirectionalLightInfo( directionalLight, directLight );",
      "getDirectionalLightInfo( directionalLight, directLight ); keyShadow = 1.0;",
    );
    replaceFragment(shader, "#include <lights_fragment_begin>", lights);
    replaceFragment(
      shader,
      "#include <aomap_fragment>",
      after(
        "#include <aomap_fragment>",
        `reflectedLight.indirectDiffuse *= mix( vec3( 0.70, 0.52, 0.46 ), vec3( 1.0 ), vSite.y );
        reflectedLight.indirectSpecular *= vSite.y * vSite.y;`,
      ),
    );
    // Pressure glows by itself, so that shade does not change what is read off the scale.
    replaceFragment(
      shader,
      "#include <opaque_fragment>",
      before(
        "#include <opaque_fragment>",
        `// The unloaded skin is glass, clear where it faces the eye and milky at its rim, so that the
        // loaded side shows through; the loaded skin is opaque.
        float facing = saturate( dot( smoothNormal, geometryViewDir ) );
        outgoingLight = mix( outgoingLight, vec3( 0.50, 0.56, 0.63 ) * ( 0.55 + 0.45 * facing ), 0.7 * pressureShown );
        float load = vPressure / pressureMost;
        float told = pressureShown * smoothstep( 0.01, 0.05, load );
        outgoingLight = mix( outgoingLight, colourMap( load ) * 0.9, told );
        diffuseColor.a = mix( diffuseColor.a, mix( mix( 0.85, 0.22, facing ), 1.0, told ), pressureShown );
        outgoingLight = mix( outgoingLight, weightMap( vBoneWeight ) * ( 0.3 + 0.7 * facing ), weightsShown );`,
      ),
    );
  };
  material.customProgramCacheKey = () => `skin-${detail}-${shared.quality.occlusion}`;
  return material;
}

/** `long`: the loaf's long axis at rest; across it the loaf is cut, and shows its crumb. */
export function breadMaterial(
  colour: Color,
  vertexColours: boolean,
  nodes: IUniform<Texture>,
  shared: Shared,
  long: Vector3,
): MeshStandardMaterial {
  const material = new MeshStandardMaterial({
    color: vertexColours ? new Color(1, 1, 1) : colour,
    vertexColors: vertexColours,
    roughness: 0.82,
  });
  const detail = shared.quality.detail;
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes);
    replaceVertex(shader, "#include <beginnormal_vertex>", EMBED_NORMAL);
    passRest(shader);
    occlude(shader, shared, "hands");
    shader.uniforms["longAxis"] = { value: long };
    replaceVertex(
      shader,
      "#include <common>",
      after("#include <common>", "uniform vec3 longAxis;\nvarying float vCut;"),
    );
    replaceVertex(
      shader,
      "#include <project_vertex>",
      after("#include <project_vertex>", "vCut = abs( dot( normal, longAxis ) );"),
    );
    replaceFragment(
      shader,
      "#include <color_pars_fragment>",
      after("#include <color_pars_fragment>", `varying float vCut;\n${BREAD_COLOUR}`),
    );
    replaceFragment(
      shader,
      "#include <color_fragment>",
      after(
        "#include <color_fragment>",
        `float crumb; float flour; float pore;
        diffuseColor.rgb = breadColour( diffuseColor.rgb, vRest, vCut, crumb, flour, pore );`,
      ),
    );
    replaceFragment(
      shader,
      "#include <roughnessmap_fragment>",
      after("#include <roughnessmap_fragment>", "roughnessFactor = mix( 0.66, 0.95, max( crumb, flour ) );"),
    );
    if (detail) {
      replaceFragment(
        shader,
        "#include <normal_fragment_maps>",
        after(
          "#include <normal_fragment_maps>",
          `float relief = mix( 420e-6 * noise3( vRest * 150.0 ) + 220e-6 * noise3( vRest * 560.0 ) * seen( vRest, 1.0 / 560.0 ),
            220e-6 * noise3( vRest * 240.0 ), crumb );
          normal = bumped( - vViewPosition, normal, relief );`,
        ),
      );
    }
  };
  material.customProgramCacheKey = () => `bread-${detail}-${shared.quality.occlusion}`;
  return material;
}

/** Crust from golden to brown as the model's colour says, blistered and here and there floury;
 * crumb, full of pores, where the loaf is cut. */
const BREAD_COLOUR = /* glsl */ `
vec3 breadColour( vec3 given, vec3 at, float cut, out float crumb, out float flour, out float pore ) {
  float patches = noise3( at * 70.0 ) * 0.6 + noise3( at * 190.0 ) * 0.4;
  crumb = smoothstep( 0.86, 0.97, cut + 0.05 * ( patches - 0.5 ) );
  float bubbles = noise3( at * 480.0 ) * 0.6 + noise3( at * 1150.0 ) * 0.4;
  pore = smoothstep( 0.50, 0.78, bubbles ) * seen( at, 1.0 / 480.0 );
  // Crust: what was given, less orange, uneven.
  vec3 crust = given * vec3( 1.12, 1.05, 1.65 );
  crust *= mix( vec3( 0.66, 0.56, 0.46 ), vec3( 1.16, 1.14, 1.08 ), smoothstep( 0.2, 0.8, patches ) );
  float light = dot( given, vec3( 0.3, 0.55, 0.15 ) );
  flour = smoothstep( 0.62, 0.85, noise3( at * 240.0 ) ) * smoothstep( 0.42, 0.7, patches ) * smoothstep( 0.34, 0.22, light );
  crust = mix( crust, vec3( 0.80, 0.70, 0.56 ), 0.4 * flour );
  vec3 soft = vec3( 0.93, 0.75, 0.51 ) * ( 0.88 + 0.2 * patches ) * mix( vec3( 1.0 ), vec3( 0.66, 0.56, 0.44 ), pore );
  crust *= 0.9 + 0.2 * noise3( at * 900.0 ) * seen( at, 1.0 / 900.0 );
  flour *= 1.0 - crumb;
  return mix( crust, soft, crumb );
}
`;

/** Rubber, flesh cells and ghosts: embedded, in one colour. */
export function plainEmbeddedMaterial(
  material: MeshStandardMaterial,
  nodes: IUniform<Texture>,
  shared: Shared,
  clip: IUniform | null = null,
  inset = 0,
): MeshStandardMaterial {
  const flat = material.flatShading;
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes, inset);
    if (!flat) replaceVertex(shader, "#include <beginnormal_vertex>", EMBED_NORMAL);
    if (clip !== null) clipCells(shader, clip);
    occlude(shader, shared, material.transparent ? "none" : flat ? "none" : "hands");
  };
  material.customProgramCacheKey = () =>
    `embedded-${flat}-${material.transparent}-${clip !== null}-${inset}-${shared.quality.occlusion}`;
  return material;
}

/** Leaves out whole cells whose rest centre lies beyond a plane. */
function clipCells(shader: Shader, clip: IUniform): void {
  shader.uniforms["clipPlane"] = clip;
  replaceVertex(
    shader,
    "#include <common>",
    after("#include <common>", "uniform vec4 clipPlane;\nattribute vec3 cell;"),
  );
  replaceVertex(
    shader,
    "#include <project_vertex>",
    after(
      "#include <project_vertex>",
      "if ( dot( clipPlane.xyz, cell ) > clipPlane.w ) gl_Position = vec4( 2.0, 2.0, 2.0, 1.0 );",
    ),
  );
}

export function embeddedDepthMaterial(
  nodes: IUniform<Texture>,
  inset = 0,
  clip: IUniform | null = null,
): MeshDepthMaterial {
  const material = new MeshDepthMaterial();
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes, inset);
    if (clip !== null) clipCells(shader, clip);
  };
  material.customProgramCacheKey = () => `embedded-depth-${inset}-${clip !== null}`;
  return material;
}

/** Two millimetres, seen from half a metre. */
const LIFT = "gl_Position.z -= 8.0e-5 * gl_Position.w;";

/** Edges of tetrahedra and triangles, drawn a little nearer than they are: not to sink into the
 * surface they lie in. */
export function embeddedLineMaterial(colour: Color, nodes: IUniform<Texture>): LineBasicMaterial {
  const material = new LineBasicMaterial({
    color: colour,
    transparent: true,
    opacity: 0.55,
    depthWrite: false,
  });
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes);
    replaceVertex(shader, "#include <project_vertex>", after("#include <project_vertex>", LIFT));
  };
  material.customProgramCacheKey = () => "embedded-line";
  return material;
}

/** Five millimetres, seen from half a metre: pressed flesh sinks into what presses it. */
const LIFT_LOADED = "gl_Position.z -= 2.0e-4 * gl_Position.w;";

/** The loaded part of the skin alone, in the colours of the pressure: it shows through the hand. */
export function pressureMaterial(nodes: IUniform<Texture>, shared: Shared): MeshBasicMaterial {
  const material = new MeshBasicMaterial({ transparent: true, depthWrite: false, side: DoubleSide });
  material.onBeforeCompile = (shader) => {
    embed(shader, nodes);
    shader.uniforms["pressureMost"] = shared.pressureMost;
    replaceVertex(
      shader,
      "#include <common>",
      after("#include <common>", "attribute float pressure; varying float vPressure;"),
    );
    replaceVertex(
      shader,
      "#include <project_vertex>",
      after("#include <project_vertex>", `vPressure = pressure; ${LIFT_LOADED}`),
    );
    replaceFragment(
      shader,
      "#include <common>",
      after("#include <common>", `varying float vPressure; uniform float pressureMost;\n${COLOUR_MAPS}`),
    );
    replaceFragment(
      shader,
      "#include <opaque_fragment>",
      before(
        "#include <opaque_fragment>",
        `float load = vPressure / pressureMost;
        diffuseColor.a = smoothstep( 0.01, 0.05, load );
        outgoingLight = colourMap( load ) * 0.9;`,
      ),
    );
  };
  material.customProgramCacheKey = () => "pressure";
  return material;
}

/** Draws nothing but depth: what comes after hides behind it. It takes its turn among transparent
 * things, so that the ground is drawn before. */
export function depthOnly(material: Material): Material {
  material.colorWrite = false;
  material.transparent = true;
  return material;
}

export function paintMaterial(colour: Color, vertexColours: boolean, shared: Shared): MeshStandardMaterial {
  const material = new MeshStandardMaterial({
    color: vertexColours ? new Color(1, 1, 1) : colour,
    vertexColors: vertexColours,
    roughness: 0.34,
    metalness: 0.0,
  });
  material.onBeforeCompile = (shader) => occlude(shader, shared, "hands");
  material.customProgramCacheKey = () => `paint-${shared.quality.occlusion}`;
  return material;
}

/** A wooden table top that fades into the dark around the place of interest. */
export function groundMaterial(
  shared: Shared,
  centre: IUniform,
  reach: IUniform<number>,
): MeshStandardMaterial {
  const material = new MeshStandardMaterial({
    color: 0xffffff,
    roughness: 0.62,
    envMapIntensity: 0.7,
    transparent: true,
  });
  material.onBeforeCompile = (shader) => {
    occlude(shader, shared, "all");
    shader.uniforms["centre"] = centre;
    shader.uniforms["reach"] = reach;
    replaceVertex(shader, "#include <common>", after("#include <common>", "varying vec3 vGround;"));
    replaceVertex(
      shader,
      "#include <project_vertex>",
      after("#include <project_vertex>", "vGround = position;"),
    );
    replaceFragment(
      shader,
      "#include <common>",
      after(
        "#include <common>",
        `varying vec3 vGround; uniform vec3 centre; uniform float reach;\n${NOISE}\n${shared.quality.detail ? "#define FINE\n" : ""}${WOOD}`,
      ),
    );
    replaceFragment(
      shader,
      "#include <color_fragment>",
      after(
        "#include <color_fragment>",
        `float sheen;
        diffuseColor.rgb = wood( vGround.xz, sheen );
        diffuseColor.a *= 1.0 - smoothstep( 0.45 * reach, reach, length( vGround.xz - centre.xz ) );`,
      ),
    );
    replaceFragment(
      shader,
      "#include <roughnessmap_fragment>",
      after("#include <roughnessmap_fragment>", "roughnessFactor = sheen;"),
    );
  };
  material.customProgramCacheKey = () => `ground-${shared.quality.detail}-${shared.quality.occlusion}`;
  return material;
}

/** Planks of oiled walnut along x, 90 mm wide; every frequency fades before it would shimmer. */
const WOOD = /* glsl */ `
vec3 wood( vec2 at, out float sheen ) {
  float footprint = length( fwidth( at ) );
  float lane = at.y / 0.09;
  float plank = floor( lane );
  float tone = hash3( vec3( plank, 3.0, 7.0 ) );
  float across = fract( lane );
  float along = at.x * 3.2 + 17.0 * tone;
  float bend = noise3( vec3( along * 0.55, across * 1.3, 9.0 * tone ) );
  float streak = 0.5;
  float wander = 0.2;
#ifdef FINE
  streak = noise3( vec3( along * 1.3, across * 16.0, tone * 20.0 ) );
  wander = 0.35 * noise3( vec3( along * 2.0, across * 5.0, tone ) );
#endif
  float rings = 0.5 + 0.5 * sin( 6.2832 * ( across * 3.1 + 2.6 * bend + wander ) );
  rings = mix( 0.5, rings, 1.0 - smoothstep( 0.004, 0.016, footprint ) );
  float fibre = noise3( vec3( along * 4.5, across * 70.0, tone * 40.0 ) );
  fibre = mix( 0.5, fibre, 1.0 - smoothstep( 0.0004, 0.0020, footprint ) );
  float shade = clamp( 0.48 + 0.22 * ( rings - 0.5 ) + 0.34 * ( fibre - 0.5 ) + 0.30 * ( streak - 0.5 ) + 0.26 * ( tone - 0.5 ), 0.0, 1.0 );
  vec3 colour = mix( vec3( 0.112, 0.052, 0.026 ), vec3( 0.330, 0.180, 0.092 ), shade );
  float seam = min( across, 1.0 - across ) * 0.09;
  float width = 0.0007;
  float gap = ( 1.0 - smoothstep( width, width + max( footprint, 0.0004 ), seam ) ) * min( 1.0, width / max( footprint, 1e-6 ) );
  colour *= 1.0 - 0.75 * gap;
  sheen = 0.60 + 0.22 * ( fibre - 0.5 ) + 0.16 * ( 1.0 - shade ) + 0.3 * gap;
  return colour;
}
`;
