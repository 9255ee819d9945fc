//! The light that a surface sends to the eye.

use super::V;
use super::ambient::{GroundOcclusion, Plane};
use super::assemble::Geometry;
use super::camera::View;
use super::clip::Screen;
use super::colour::vector;
use super::pattern;
use super::scene3d::{Ground, Light, Material, Pattern, Scene3d};
use super::shadow::Shadow;
use super::skin;

/// Highlight that a nail has beside that of skin: strength and exponent.
const NAIL_SHINE: (f32, f32) = (0.2, 60.0);

/// Everything shading looks at.
pub(super) struct Shader<'a> {
    pub geometry: &'a Geometry,
    pub screen: &'a Screen,
    pub view: &'a View,
    pub shadow: Shadow,
    pub occlusion: Option<GroundOcclusion>,
    pub ground: Option<GroundPlane>,
    sky: Lights,
    horizon: V,
    zenith: V,
}

struct Lights {
    towards: V,
    up: V,
    key: V,
    sky: V,
    floor: V,
}

/// The ground relative to the camera's target.
pub(super) struct GroundPlane {
    pub plane: Plane,
    /// Directions of the pattern's coordinates.
    axes: [V; 2],
    /// Pattern coordinates of the target \[m\].
    offset: [f32; 2],
    pattern: Pattern,
    /// Height of the eye above it \[m\].
    height: f32,
    /// Distance at which it has faded into the backdrop \[m\].
    fade: f32,
}

impl GroundPlane {
    /// `None` when the eye lies below it.
    pub(super) fn new(ground: &Ground, origin: thenar_core::Vec3, view: &View) -> Option<Self> {
        let normal = ground.normal.try_normalize(1e-12)?;
        let axes = if normal.y.abs() > 0.99 {
            [thenar_core::Vec3::x(), thenar_core::Vec3::z()]
        } else {
            let (a, b) = thenar_core::math::tangents(&normal);
            [a, b]
        };
        let plane =
            Plane { point: (ground.point - origin).cast::<f32>(), normal: normal.cast::<f32>() };
        let height = plane.normal.dot(&(view.eye - plane.point));
        (height > 1e-6).then(|| Self {
            plane,
            axes: axes.map(|a| a.cast()),
            offset: axes.map(|a| a.dot(&origin) as f32),
            pattern: ground.pattern,
            height,
            fade: 9.0 * view.eye.norm().max(height),
        })
    }

    /// One over the distance at which the ray through (x, y) meets the ground; may be negative.
    pub(super) fn nearness(&self, ray: &V) -> f32 {
        -self.plane.normal.dot(ray) / self.height
    }
}

impl<'a> Shader<'a> {
    pub(super) fn new(
        scene: &Scene3d,
        geometry: &'a Geometry,
        screen: &'a Screen,
        view: &'a View,
        shadow: Shadow,
        occlusion: Option<GroundOcclusion>,
        ground: Option<GroundPlane>,
    ) -> Self {
        let up = ground.as_ref().map_or_else(V::y, |g| g.plane.normal);
        let light: &Light = &scene.light;
        let sky = Lights {
            towards: towards(light),
            up,
            key: vector(light.key),
            sky: vector(light.sky),
            floor: vector(light.floor),
        };
        let (horizon, zenith) = (vector(scene.backdrop.horizon), vector(scene.backdrop.zenith));
        Self { geometry, screen, view, shadow, occlusion, ground, sky, horizon, zenith }
    }

    /// Colour where nothing is.
    pub(super) fn backdrop(&self, ray: &V) -> V {
        let rise = self.sky.up.dot(&ray.normalize());
        let t = (rise * 2.2 + 0.05).clamp(0.0, 1.0);
        self.horizon + (self.zenith - self.horizon) * (t * t * (3.0 - 2.0 * t))
    }

    /// Colour of the ground along the ray through (x, y).
    pub(super) fn ground(&self, x: f32, y: f32, ray: &V) -> V {
        let Some(ground) = &self.ground else { return self.backdrop(ray) };
        let distance = 1.0 / ground.nearness(ray).max(1e-9);
        let p = self.view.eye + ray * distance;
        let next = self.view.ray(x, y + 1.0);
        let step = p - (self.view.eye + next / ground.nearness(&next).max(1e-9));
        let footprint = step.norm().min(1e3).max(distance / self.view.focal);
        let place = |k: usize| ground.axes[k].dot(&p) + ground.offset[k];
        let albedo = pattern::colour(&ground.pattern, place(0), place(1), footprint);
        let open = self.occlusion.as_ref().map_or(1.0, |o| o.open(&p));
        let normal = ground.plane.normal;
        let material = Material { specular: 0.0, rim: 0.0, ..Material::matte([1.0; 3]) };
        let lit = self.reflect(&p, &normal, &albedo, open, &material);
        // The ground fades into the backdrop before it flickers.
        let far = ((p - V::zeros()).norm() / ground.fade).min(1.0);
        let fade = far * far * (3.0 - 2.0 * far);
        lit + (self.horizon - lit) * fade
    }

    /// Colour and opacity of a screen triangle at (x, y).
    pub(super) fn surface(&self, triangle: u32, x: f32, y: f32) -> (V, f32) {
        let corners = self.screen.triangles[triangle as usize];
        let mesh = self.screen.mesh_of[triangle as usize] as usize;
        let material = &self.geometry.materials[mesh];
        let w = self.weights(corners, x, y);
        let mix = |values: &[V]| -> V {
            values[corners[0] as usize] * w[0]
                + values[corners[1] as usize] * w[1]
                + values[corners[2] as usize] * w[2]
        };
        let mut colour = mix(&self.geometry.colours);
        let mut material = *material;
        if let Some(site) = self.geometry.site(corners, &w) {
            let nail;
            (colour, nail) = skin::colour(&colour, &site);
            material.specular += NAIL_SHINE.0 * nail;
            material.gloss += NAIL_SHINE.1 * nail;
        }
        if material.unlit {
            return (colour, material.opacity);
        }
        let p = mix(&self.geometry.points);
        let eye = (self.view.eye - p).normalize();
        let mut normal = mix(&self.geometry.normals).try_normalize(1e-12).unwrap_or(eye);
        if self.geometry.two_sided[mesh] && normal.dot(&eye) < 0.0 {
            normal = -normal;
        }
        let open: f32 = (0..3).map(|k| self.geometry.ambient[corners[k] as usize] * w[k]).sum();
        let reflected = self.reflect(&p, &normal, &colour, open, &material);
        let edge = 1.0 - normal.dot(&eye).clamp(0.0, 1.0);
        let opacity = material.opacity + (1.0 - material.opacity) * 0.5 * edge * edge * edge;
        (reflected, if material.opacity < 1.0 { opacity } else { 1.0 })
    }

    /// Perspective-correct barycentric weights of (x, y), moved into the triangle.
    fn weights(&self, corners: [u32; 3], x: f32, y: f32) -> [f32; 3] {
        let v = corners.map(|i| self.screen.vertices[i as usize]);
        let part = |j: usize, k: usize| {
            (v[k][0] - v[j][0]) * (y - v[j][1]) - (v[k][1] - v[j][1]) * (x - v[j][0])
        };
        let flat = [part(1, 2).max(0.0), part(2, 0).max(0.0), part(0, 1).max(0.0)];
        let weighted = [flat[0] * v[0][2], flat[1] * v[1][2], flat[2] * v[2][2]];
        let sum = weighted[0] + weighted[1] + weighted[2];
        if sum > 0.0 { weighted.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
    }

    /// Light reflected to the eye by a surface of this `albedo`, of which `open` of the ambient
    /// light arrives.
    fn reflect(&self, p: &V, normal: &V, albedo: &V, open: f32, material: &Material) -> V {
        // What is drawn over everything lies in nothing's shadow.
        // In the narrowest gap some light still gets about.
        let open = if material.on_top { 1.0 } else { open.max(0.1) };
        let light = &self.sky;
        let eye = (self.view.eye - p).normalize();
        let facing = normal.dot(&light.towards);
        let wrap = vector(material.wrap);
        // Flesh scatters light past the terminator: red farthest.
        let diffuse = wrap.map(|w| {
            let c = ((facing + w) / (1.0 + w)).max(0.0);
            c * (1.0 - 0.35 * w)
        });
        let lit = if material.on_top {
            1.0
        } else if diffuse.x > 0.0 {
            self.shadow.lit(p, normal, 0.004 * wrap.x)
        } else {
            0.0
        };
        // Some light finds its way round an occluder by reflection off the surface itself.
        let open_colour = albedo.map(|a| open / (1.0 - a.min(0.95) * (1.0 - open)));
        let half_up = 0.5 + 0.5 * normal.dot(&light.up);
        let ambient =
            (light.floor + (light.sky - light.floor) * half_up).component_mul(&open_colour);
        let body = albedo.component_mul(&(light.key.component_mul(&diffuse) * lit + ambient));

        if material.specular + material.rim <= 0.0 {
            return body;
        }
        let across = 1.0 - normal.dot(&eye).clamp(0.0, 1.0);
        let fresnel = across * across * across * across;
        let halfway = (light.towards + eye).normalize();
        let highlight = normal.dot(&halfway).max(0.0).powf(material.gloss);
        let strength = material.specular * (1.0 + 4.0 * fresnel) * highlight;
        let shine = light.key * (strength * lit * facing.clamp(0.0, 0.25) * 4.0);
        let mirrored = normal * (2.0 * normal.dot(&eye)) - eye;
        let rise = (0.5 + 0.9 * mirrored.dot(&light.up)).clamp(0.0, 1.0);
        let surroundings = light.floor + (light.sky * 1.6 - light.floor) * rise;
        let sheen = surroundings * ((0.16 * material.specular + material.rim * fresnel) * open);
        body + shine + sheen
    }
}

/// Unit direction towards the key light.
pub(super) fn towards(light: &Light) -> V {
    light.direction.cast::<f32>().try_normalize(1e-12).unwrap_or_else(V::y)
}
