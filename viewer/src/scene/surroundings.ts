// The place: light from a window, a dark room, a wooden table where the scene has a ground plane.

import {
  BackSide,
  Box3,
  CircleGeometry,
  Color,
  DirectionalLight,
  Group,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  PMREMGenerator,
  Scene,
  ShaderMaterial,
  SphereGeometry,
  Vector3,
  type IUniform,
  type Texture,
  type WebGLRenderer,
} from "three";
import { groundMaterial, type Shared } from "./materials";

/** Where the key light comes from. */
const KEY = new Vector3(-0.42, 0.86, 0.34).normalize();
const KEY_DISTANCE = 1.2;
/** Blur of shadows, m. */
const PENUMBRA = 0.0032;

export class Surroundings {
  readonly key = new DirectionalLight(0xfff4e8, 2.2);
  readonly rim = new DirectionalLight(0xcfe0ff, 0.4);
  /** Behind everything: the far side of a bright room. */
  readonly backdrop = backdrop();
  readonly ground: Mesh;
  readonly group = new Group();
  private readonly fill: HemisphereLight;
  private readonly centre: IUniform<Vector3> = { value: new Vector3() };
  private readonly reach: IUniform<number> = { value: 0.9 };

  constructor(
    private readonly shared: Shared,
    renderer: WebGLRenderer,
    scene: Scene,
  ) {
    const { quality } = shared;
    this.key.castShadow = true;
    this.key.shadow.mapSize.setScalar(quality.shadowSize);
    this.key.shadow.bias = -0.0004;
    this.fill = new HemisphereLight(0xdfe8f2, 0x6b5442, quality.software ? 1.15 : 0.12);
    this.rim.position.set(0.6, 0.45, -0.8);
    this.ground = new Mesh(
      new CircleGeometry(3, 64).rotateX(-Math.PI / 2),
      groundMaterial(shared, this.centre, this.reach),
    );
    this.ground.receiveShadow = true;
    this.ground.renderOrder = -1;
    this.group.add(this.key, this.key.target, this.rim, this.fill, this.ground);
    scene.add(this.backdrop);
    // Looking light up in a picture of the room costs a software renderer too much.
    if (!quality.software) scene.environment = room(renderer);
    scene.environmentIntensity = 0.4;
  }

  /** Lights and shadows the box of interest. */
  surround(box: Box3): void {
    const centre = box.getCenter(this.centre.value);
    const radius = Math.min(0.6, Math.max(0.08, 0.5 * box.getSize(SIZE).length()));
    this.reach.value = Math.max(0.75, 4 * radius);
    this.key.target.position.copy(centre);
    this.key.position.copy(centre).addScaledVector(KEY, KEY_DISTANCE);
    const camera = this.key.shadow.camera;
    const span = 1.25 * radius;
    camera.left = camera.bottom = -span;
    camera.right = camera.top = span;
    camera.near = KEY_DISTANCE - 2 * radius - 0.1;
    camera.far = KEY_DISTANCE + 2 * radius + 0.3;
    camera.updateProjectionMatrix();
    const texel = (2 * span) / this.shared.quality.shadowSize;
    this.key.shadow.radius = Math.max(1.2, PENUMBRA / texel);
    this.key.shadow.normalBias = Math.max(0.0007, 2.4 * texel);
  }

  setShadows(on: boolean): void {
    this.key.castShadow = on;
  }
}

/** Below, at and above the horizon. */
const BACKDROP = {
  dark: [0x12151a, 0x39424d, 0x171b21],
  light: [0x8f979f, 0xdfe4e9, 0xaab4be],
} as const;

const SIZE = new Vector3();

/** A gradient from a lit horizon to the dark above; drawn behind everything. */
function backdrop(): Mesh {
  const material = new ShaderMaterial({
    side: BackSide,
    depthWrite: false,
    depthTest: false,
    toneMapped: false,
    uniforms: { low: { value: new Color() }, middle: { value: new Color() }, high: { value: new Color() } },
    vertexShader: /* glsl */ `
      varying vec3 vAt;
      void main() {
        vAt = position;
        gl_Position = projectionMatrix * vec4( mat3( modelViewMatrix ) * position, 1.0 );
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 low; uniform vec3 middle; uniform vec3 high;
      varying vec3 vAt;
      float grain( vec2 p ) { return fract( 52.9829189 * fract( dot( p, vec2( 0.06711056, 0.00583715 ) ) ) ); }
      void main() {
        float y = normalize( vAt ).y;
        vec3 c = mix( low, middle, smoothstep( -0.75, 0.08, y ) );
        c = mix( c, high, smoothstep( 0.08, 0.85, y ) );
        gl_FragColor = vec4( c, 1.0 );
        #include <colorspace_fragment>
        // Less than one step of a byte: hides bands.
        gl_FragColor.rgb += ( grain( gl_FragCoord.xy ) - 0.5 ) / 160.0;
      }`,
  });
  const light = matchMedia("(prefers-color-scheme: light)");
  const colour = () => {
    const [low, middle, high] = light.matches ? BACKDROP.light : BACKDROP.dark;
    material.uniforms["low"].value.set(low);
    material.uniforms["middle"].value.set(middle);
    material.uniforms["high"].value.set(high);
  };
  colour();
  light.addEventListener("change", colour);
  const mesh = new Mesh(new SphereGeometry(5, 32, 24), material);
  mesh.frustumCulled = false;
  mesh.renderOrder = -10;
  return mesh;
}

/** A dim room with a window above, a bright wall and a strip of light: what smooth things mirror. */
function room(renderer: WebGLRenderer): Texture {
  const scene = new Scene();
  const shell = new Mesh(
    new SphereGeometry(10, 24, 16),
    new ShaderMaterial({
      side: BackSide,
      vertexShader:
        "varying vec3 vAt; void main() { vAt = position; gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 ); }",
      fragmentShader: `varying vec3 vAt; void main() {
        float y = normalize( vAt ).y;
        vec3 c = mix( vec3( 0.20, 0.13, 0.08 ), vec3( 0.34, 0.37, 0.42 ), smoothstep( -0.5, 0.2, y ) );
        c = mix( c, vec3( 0.75, 0.82, 0.92 ), smoothstep( 0.2, 0.95, y ) );
        gl_FragColor = vec4( c, 1.0 );
      }`,
    }),
  );
  scene.add(shell);
  const panel = (x: number, y: number, z: number, w: number, h: number, light: number) => {
    const mesh = new Mesh(
      new CircleGeometry(1, 4),
      new MeshBasicMaterial({ color: new Color().setScalar(light) }),
    );
    mesh.scale.set(w, h, 1);
    mesh.position.set(x, y, z);
    mesh.lookAt(0, 0, 0);
    scene.add(mesh);
  };
  panel(-3.5, 6.5, 3, 2.6, 2.6, 14);
  panel(6, 2.2, -4, 0.7, 3.2, 8);
  panel(-6.5, 1.2, -2.5, 1.2, 2.2, 3);
  const generator = new PMREMGenerator(renderer);
  const texture = generator.fromScene(scene, 0.03).texture;
  generator.dispose();
  return texture;
}
