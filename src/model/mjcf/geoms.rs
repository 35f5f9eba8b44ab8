//! `<geom>` of a body as capsules that contain it, and the meshes that it is made of.
//!
//! Shapes never change the mechanics: a geom that cannot be read is left out.

use super::bodies::{Held, Reading};
use super::defaults::Attributes;
use crate::model::capsule::few;
use crate::model::{Ball, Capsule, INPUT_LIMITS, LinkMesh};
use crate::spatial::Transform;
use nalgebra::Vector3;
use roxmltree::Node;

/// A geom with all that default classes and the frames around it say.
struct Geom<'a> {
    node: Node<'a, 'a>,
    attributes: Attributes<'a>,
    /// Of the frames between body and geom, in the body's frame.
    frame: Transform,
}

impl Geom<'_> {
    /// Whether it may touch others: what is only seen has both masks 0.
    fn collides(&self) -> bool {
        let mask = |name: &str| {
            self.attributes
                .get(name)
                .and_then(|t| t.trim().parse::<i64>().ok())
                .unwrap_or(1)
        };
        mask("contype") != 0 || mask("conaffinity") != 0
    }

    /// A geom of any type with a mesh has its shape or, as MuJoCo makes it, one that stands for it.
    fn is_mesh(&self) -> bool {
        self.attributes.get("mesh").is_some()
    }

    /// As many finite numbers as there are, seven at most.
    fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let words = self.attributes.get(name)?.split_whitespace().take(7);
        words.map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect()
    }
}

impl<'a> Reading<'a> {
    /// Capsules around the geoms of a body, those that collide or else those that are seen. Where none of the first has a shape
    /// of its own, the meshes of the first, or else of the second, are put to the list.
    pub(super) fn shape(&mut self, inside: &[Held<'a>], name: &str) -> Vec<Capsule> {
        let geoms = inside.iter().filter(|h| h.node.has_tag_name("geom")).map(|h| self.geom(h));
        let (colliding, seen): (Vec<_>, Vec<_>) = geoms.partition(Geom::collides);
        let (own, drawn) = (self.capsules(&colliding), self.capsules(&seen));
        if !own.is_empty() {
            return own;
        }
        let of = |geoms: &[Geom<'a>]| -> Vec<LinkMesh> { geoms.iter().filter_map(|g| self.mesh(g, name)).collect() };
        let meshes = match of(&colliding) {
            meshes if meshes.is_empty() && drawn.is_empty() => of(&seen),
            meshes => meshes,
        };
        self.meshes.extend(meshes);
        drawn
    }

    fn geom(&self, held: &Held<'a>) -> Geom<'a> {
        Geom {
            node: held.node,
            attributes: self.defaults.attributes(held.node, held.class),
            frame: held.pose,
        }
    }

    fn capsules(&self, geoms: &[Geom<'a>]) -> Vec<Capsule> {
        let own = geoms.iter().filter(|g| !g.is_mesh());
        let readable = own.filter_map(|g| self.capsule(g));
        few(readable.take(INPUT_LIMITS.capsules_per_link).collect())
    }

    fn capsule(&self, geom: &Geom<'a>) -> Option<Capsule> {
        let size = geom.numbers("size").unwrap_or_default();
        let (first, second) = (*size.first()?, size.get(1).copied().unwrap_or(0.0));
        let up = |z: f64| Vector3::new(0.0, 0.0, z);
        let kind = geom.attributes.get("type").unwrap_or("sphere");
        let pose = match geom.numbers("fromto") {
            Some(_) => geom.frame,
            None => self.place(geom)?,
        };
        let balls = match (geom.numbers("fromto").as_deref(), kind) {
            (Some(&[a, b, c, d, e, f]), "capsule" | "cylinder") => {
                vec![(Vector3::new(a, b, c), first), (Vector3::new(d, e, f), first)]
            }
            (None, "capsule" | "cylinder") => vec![(up(-second), first), (up(second), first)],
            (None, "sphere") => vec![(up(0.0), first)],
            (None, "box") => corners([first, second, *size.get(2)?]),
            _ => return None,
        };
        Capsule::around(&balls)
            .map(|c| c.moved(&pose))
            .filter(|c| Capsule::around(&c.balls()).is_some())
    }

    fn mesh(&self, geom: &Geom<'a>, link: &str) -> Option<LinkMesh> {
        let asset = self.assets.get(geom.attributes.get("mesh")?)?;
        Some(LinkMesh {
            link: link.to_string(),
            file: asset.file.clone(),
            reference: asset.reference,
            scale: asset.scale,
            pose: self.place(geom)?,
        })
    }

    /// Of a geom in the frame of its body.
    fn place(&self, geom: &Geom<'a>) -> Option<Transform> {
        let own = self.pose_of(geom.node, |name| geom.attributes.get(name)).ok()?;
        Some(geom.frame * own)
    }
}

fn corners(half: [f64; 3]) -> Vec<Ball> {
    let corner = |k: usize| Vector3::from_fn(|i, _| if k >> i & 1 == 1 { half[i] } else { -half[i] });
    (0..8).map(|k| (corner(k), 0.0)).collect()
}
