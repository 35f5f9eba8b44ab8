//! Identified bodies in the user's own URDF file: meshes, materials, comments, frames and other links stay as they are.

use super::frames::urdf_gravity;
use super::missing::PATCHED;
use super::urdf::with_comment;
use super::{FinalModel, ModelFormat};
use crate::formats::significant;
use crate::model::{
    CarriedLinks, ChainEnds, FieldProblem, Joint, ModelError, NewBody, Robot, Rounding, from_urdf, urdf_carried, urdf_with_bodies,
};
use crate::spatial::{LinkInertia, PhysicalInertia, Transform};

/// A file with the identified bodies put in.
#[derive(Debug, Clone, PartialEq)]
pub struct Patched {
    /// The whole file with the identified bodies in it.
    pub urdf: String,
    /// What a user should know about how it was done.
    pub notes: Vec<String>,
}

/// Differences of frames in files that describe the same arm (m, and entries of rotations): digits that one of them rounded.
const SAME_FRAME: f64 = 1e-5;

/// The identified robot as a file describes it.
struct Counterpart {
    /// With frames as in the file.
    robot: Robot,
    /// Which format's report says what the file does not hold.
    reported_as: &'static str,
}

impl FinalModel {
    /// The user's file with the identified bodies and friction in the links and joints of the same names.
    ///
    /// Links that are locked to a link of the chain (flanges, grippers, cameras) were identified with it. They keep what the file
    /// says of them, and the chain's link gets the rest; where no body is left by that, they lose their inertials and the chain's
    /// link gets all.
    ///
    /// A base that stands elsewhere in the file is the same arm where gravity, which is −z in URDF, is the same seen from the
    /// first joint. So is a file that holds the base tilt and the encoder offsets of this model in its frames, as the URDF files
    /// of [`text`](Self::text) do.
    ///
    /// # Errors
    /// No URDF file, or one of another arm: other joints, or frames at other places.
    pub fn patch_urdf(&self, xml: &str, base: Option<&str>, tip: Option<&str>) -> Result<Patched, Vec<FieldProblem>> {
        let of_model = |e: ModelError| e.0;
        let last = self.robot.joints().last().map(|j| j.link_name.as_str());
        let ends = ChainEnds { base, tip: tip.or(last) };
        let carried = urdf_carried(xml, ends, Rounding::Meant).map_err(of_model)?;
        let read = from_urdf(xml, self.robot.gravity(), self.robot.friction(), ends).map_err(of_model)?;
        let ours = self.counterpart(&read.robot)?;
        let (mut new, mut notes) = (Vec::new(), Vec::new());
        for ((identified, in_file), links) in ours.robot.joints().iter().zip(read.robot.joints()).zip(&carried) {
            let Some(prior) = &identified.prior else { continue };
            // The dynamics' frames are the same; the link's frame is that of this file.
            let turn = Transform::from_rotation(in_file.description_frame);
            let body = prior.inertia.about_origin().transformed(&turn);
            new.extend(bodies(body, links, &mut notes));
            new.push((links.joint.clone(), NewBody::Friction(prior.viscous, prior.coulomb)));
        }
        let patched = urdf_with_bodies(xml, &new).map_err(of_model)?;
        // The base that was asked for may hang below fixed joints that turn it; a simulation begins at the root.
        let from_root = ChainEnds { base: None, ..ends };
        let whole = from_urdf(xml, self.robot.gravity(), self.robot.friction(), from_root).ok();
        let whole = whole.filter(|w| w.robot.joint_count() == read.robot.joint_count());
        notes.extend(gravity_note(&ours.robot, whole.as_ref().map_or(&read.robot, |w| &w.robot)));
        notes.extend(self.remarks(ours.reported_as));
        let top = format!("bodies and friction as identified by dynident {}", env!("CARGO_PKG_VERSION"));
        let comment: Vec<String> = std::iter::once(top).chain(notes.iter().cloned()).collect();
        Ok(Patched {
            urdf: with_comment(in_utf8(patched), &comment),
            notes,
        })
    }

    /// The robot as it was described, or with tilt and offsets in its frames, whichever the file has.
    fn counterpart(&self, file: &Robot) -> Result<Counterpart, Vec<FieldProblem>> {
        let refuse = |what: String| {
            let remedy =
                "give the file that the robot of the identification was read from, or identify again with this file as the robot";
            vec![FieldProblem::new("/urdf", what).with_hint(remedy)]
        };
        let names = |robot: &Robot| robot.joints().iter().map(|j| j.name.clone()).collect::<Vec<_>>();
        let (ours, theirs) = (names(&self.robot), names(file));
        if ours != theirs {
            return Err(refuse(format!(
                "has the joints {}, and the model has {}",
                theirs.join(", "),
                ours.join(", ")
            )));
        }
        let described = Counterpart {
            robot: self.robot.clone(),
            reported_as: PATCHED,
        };
        let Some(elsewhere) = moved_joint(&self.robot, file) else {
            return Ok(described);
        };
        let absorbed = self.absorbed();
        if moved_joint(&absorbed, file).is_some() {
            return Err(refuse(elsewhere));
        }
        Ok(Counterpart {
            robot: absorbed,
            reported_as: ModelFormat::Urdf.name(),
        })
    }
}

/// The first joint that a file has at another place, in words.
fn moved_joint(ours: &Robot, file: &Robot) -> Option<String> {
    let differs = |a: &Joint, b: &Joint| {
        let turned = (a.placement.rotation - b.placement.rotation).amax();
        let moved = (a.placement.translation - b.placement.translation).amax();
        turned.max(moved) > SAME_FRAME
    };
    let mut pairs = ours.joints().iter().zip(file.joints()).enumerate();
    let (k, (joint, _)) = pairs.find(|(k, (a, b))| {
        // Where the base stands is nothing to the arm: which way its weight pulls is.
        let elsewhere = differs(a, b) && (*k > 0 || !has_same_gravity(ours, file));
        a.kind != b.kind || elsewhere
    })?;
    let gravity = if k == 0 {
        ", and gravity along -z of the file is not that of the model there"
    } else {
        ""
    };
    Some(format!("has joint `{}` at another place than the model{gravity}", joint.name))
}

/// Whether the gravity of a file's root frame, −z, is that of the model, both seen from the first joint.
fn has_same_gravity(ours: &Robot, file: &Robot) -> bool {
    let [a, b] = [(ours, ours.gravity()), (file, urdf_gravity(ours))]
        .map(|(robot, gravity)| robot.joints()[0].placement.rotation.transpose() * gravity);
    (a - b).norm() <= SAME_FRAME * ours.gravity().norm()
}

/// Said of a file in whose simulation the weight pulls another way than it did in the identification.
fn gravity_note(ours: &Robot, file: &Robot) -> Option<String> {
    let [x, y, z] = ours.gravity().map(|v| significant(v, 6)).into();
    (!has_same_gravity(ours, file)).then(|| {
        format!("identified with gravity [{x}, {y}, {z}] m/s^2 in the base frame; simulators let it point along -z of this file's root: mount the arm there as it stands")
    })
}

/// Bodies of a link of the chain and of those that are locked to it, which together are `body` (about the frame of the former).
fn bodies(body: LinkInertia, links: &CarriedLinks, notes: &mut Vec<String>) -> Vec<(String, NewBody)> {
    let stated = links.locked.iter().filter_map(|(name, own)| Some((name, (*own)?)));
    let stated: Vec<(&String, LinkInertia)> = stated
        .filter(|(_, own)| own.mass != 0.0 || own.inertia.amax() != 0.0)
        .collect();
    let locked = stated.iter().fold(LinkInertia::zero(), |sum, (_, own)| sum + *own);
    if let Some(rest) = less(body, locked) {
        return vec![(links.link.clone(), NewBody::Body(rest))];
    }
    let names: Vec<&str> = stated.iter().map(|(name, _)| name.as_str()).collect();
    notes.push(format!(
        "link `{}` holds the mass and inertia of {}, which were identified with it and lose their inertials: what the file says of them leaves no possible body",
        links.link,
        names.join(", ")
    ));
    let emptied = stated.iter().map(|(name, _)| ((*name).clone(), NewBody::None));
    let whole = body.physical().map(|all| (links.link.clone(), NewBody::Body(all)));
    whole.into_iter().chain(emptied).collect()
}

/// What is left of a body without a part of it, if that is a body.
fn less(body: LinkInertia, part: LinkInertia) -> Option<PhysicalInertia> {
    if part == LinkInertia::zero() {
        return body.physical();
    }
    let rest = LinkInertia {
        mass: body.mass - part.mass,
        first_moment: body.first_moment - part.first_moment,
        inertia: body.inertia - part.inertia,
    };
    let is_body = rest.pseudo_inertia().symmetric_eigenvalues().min() > 0.0;
    is_body.then(|| rest.physical()).flatten()
}

/// The text as it is written now, whatever encoding it came in.
fn in_utf8(mut xml: String) -> String {
    let declaration = xml.starts_with("<?xml").then(|| xml.find("?>")).flatten().unwrap_or(0);
    if let Some(at) = xml[..declaration].find("encoding") {
        let value = at + "encoding".len();
        let quotes: Vec<usize> = xml[value..declaration]
            .match_indices(['"', '\''])
            .map(|(i, _)| value + i)
            .collect();
        if let [open, close, ..] = quotes[..]
            && !xml[open + 1..close].eq_ignore_ascii_case("utf-8")
        {
            xml.replace_range(open + 1..close, "UTF-8");
        }
    }
    xml
}
