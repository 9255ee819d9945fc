// Pieces of shader code that several materials share.

/** Places vertices in a deformed body and turns their normals; see deformation.ts. */
export const EMBED_PARS = /* glsl */ `
uniform highp sampler2D nodeTexture;
attribute vec4 corner;
attribute vec4 weight;

vec4 nodeTexel( float node, int which ) {
  int n = int( node );
  return texelFetch( nodeTexture, ivec2( 4 * ( n & 255 ) + which, n >> 8 ), 0 );
}
vec3 embedded( int which ) {
  return weight.x * nodeTexel( corner.x, which ).xyz + weight.y * nodeTexel( corner.y, which ).xyz
    + weight.z * nodeTexel( corner.z, which ).xyz + weight.w * nodeTexel( corner.w, which ).xyz;
}
`;

export const EMBED_POSITION = /* glsl */ `vec3 transformed = embedded( 0 );`;

export const EMBED_NORMAL = /* glsl */ `
vec3 objectNormal = embedded( 1 ) * normal.x + embedded( 2 ) * normal.y + embedded( 3 ) * normal.z;
objectNormal = dot( objectNormal, objectNormal ) > 1e-12 ? normalize( objectNormal ) : normal;
`;

export const NOISE = /* glsl */ `
float hash3( vec3 p ) {
  p = fract( p * vec3( 0.1031, 0.1030, 0.0973 ) );
  p += dot( p, p.yxz + 33.33 );
  return fract( ( p.x + p.y ) * p.z );
}
float noise3( vec3 p ) {
  vec3 i = floor( p );
  vec3 f = fract( p );
  f = f * f * ( 3.0 - 2.0 * f );
  vec2 e = vec2( 0.0, 1.0 );
  return mix(
    mix( mix( hash3( i ), hash3( i + e.yxx ), f.x ), mix( hash3( i + e.xyx ), hash3( i + e.yyx ), f.x ), f.y ),
    mix( mix( hash3( i + e.xxy ), hash3( i + e.yxy ), f.x ), mix( hash3( i + e.xyy ), hash3( i + e.yyy ), f.x ), f.y ),
    f.z );
}
/** How much of a pattern with waves of that length can be seen, 0 to 1. */
float seen( vec3 at, float wave ) {
  return 1.0 - smoothstep( 0.25, 0.8, length( fwidth( at ) ) / wave );
}
/** Turns a normal as if the surface had that height; all in view space. */
vec3 bumped( vec3 at, vec3 n, float height ) {
  vec3 dx = dFdx( at );
  vec3 dy = dFdy( at );
  vec3 rx = cross( dy, n );
  vec3 ry = cross( n, dx );
  float det = dot( dx, rx );
  vec3 gradient = sign( det ) * ( dFdx( height ) * rx + dFdy( height ) * ry );
  return normalize( abs( det ) * n - gradient );
}
`;

/** Light kept out by spheres that stand for hands and for other bodies. */
export const OCCLUSION_PARS = /* glsl */ `
#ifdef OCCLUDERS
uniform vec4 occluders[ OCCLUDERS ];
varying vec3 vScene;
varying vec3 vSceneNormal;
float openness( vec3 at, vec3 n ) {
  float open = 1.0;
  for ( int i = OCCLUDERS_FROM; i < OCCLUDERS_TO; i ++ ) {
    vec4 s = occluders[ i ];
    vec3 d = s.xyz - at;
    float square = max( dot( d, d ), 1e-8 );
    float far = inversesqrt( square );
    float ratio = s.w * s.w / square;
    float cosine = dot( n, d ) * far;
    // Only part of the sphere may stand above the horizon.
    float above = smoothstep( -1.0, 1.0, cosine / max( s.w * far, 1e-4 ) );
    float hidden = min( ratio, 1.0 ) * mix( max( cosine, 0.0 ), above, 0.35 ) ;
    open *= 1.0 - 0.75 * clamp( hidden, 0.0, 1.0 );
  }
  return open;
}
#endif
`;

export const OCCLUSION_VERTEX_PARS = /* glsl */ `
#ifdef OCCLUDERS
uniform mat4 sceneFromWorld;
varying vec3 vScene;
varying vec3 vSceneNormal;
#endif
`;

export const OCCLUSION_VERTEX = /* glsl */ `
#ifdef OCCLUDERS
vScene = ( sceneFromWorld * modelMatrix * vec4( transformed, 1.0 ) ).xyz;
vSceneNormal = mat3( sceneFromWorld ) * mat3( modelMatrix ) * objectNormal;
#endif
`;

/** Dims what light comes from all around. */
export const OCCLUSION_FRAGMENT = /* glsl */ `
#ifdef OCCLUDERS
{
  float open = openness( vScene, normalize( vSceneNormal ) );
  reflectedLight.indirectDiffuse *= open;
  reflectedLight.indirectSpecular *= open;
  reflectedLight.directDiffuse *= mix( 1.0, open, 0.35 );
}
#endif
`;

/** Skin: light that enters leaves again a little further on, red furthest. */
export const SKIN_LIGHT = /* glsl */ `
float keyShadow = 1.0;
void RE_Direct_Skin( const in IncidentLight directLight, const in vec3 geometryPosition, const in vec3 geometryNormal, const in vec3 geometryViewDir, const in vec3 geometryClearcoatNormal, const in PhysicalMaterial material, inout ReflectedLight reflectedLight ) {
  float cosine = dot( smoothNormal, directLight.direction );
  float fine = dot( geometryNormal, directLight.direction );
  vec3 wrap = scatter * vec3( 0.50, 0.20, 0.12 );
  vec3 bent = vec3( mix( fine, cosine, 0.75 ), mix( fine, cosine, 0.4 ), mix( fine, cosine, 0.25 ) );
  vec3 lit = saturate( ( bent + wrap ) / ( 1.0 + wrap ) );
  lit *= mix( vec3( 1.0 ), lit, wrap * 0.8 );
  // Beyond the edge of light the shadow map only repeats that the surface faces away.
  vec3 open = pow( vec3( keyShadow ), vec3( 0.62, 1.0, 1.12 ) );
  open = mix( vec3( 1.0 ), open, smoothstep( -0.12, 0.22, cosine ) );
  reflectedLight.directDiffuse += directLight.color * lit * open * BRDF_Lambert( material.diffuseContribution );
  // A broad sheen of the skin, and a sharper one of what lies on it.
  PhysicalMaterial film = material;
  film.roughness = max( 0.22, material.roughness * 0.6 );
  vec3 gloss = 0.85 * BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, material )
    + 0.15 * BRDF_GGX( directLight.direction, geometryViewDir, geometryNormal, film );
  reflectedLight.directSpecular += saturate( fine ) * keyShadow * directLight.color * gloss;
}
#undef RE_Direct
#define RE_Direct RE_Direct_Skin
`;
