//! Names, order and units of the standard parameters.

use crate::model::Robot;
use crate::spatial::LinkInertia;
use nalgebra::DVector;

/// The ten inertial parameters of a link, in the paper's order (3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Inertial {
    /// Mass (kg).
    M,
    /// First moment along x [kg m].
    MX,
    /// First moment along y [kg m].
    MY,
    /// First moment along z [kg m].
    MZ,
    /// Moment of inertia about x [kg m²].
    XX,
    /// Product of inertia xy, entry of the tensor [kg m²].
    XY,
    /// Product of inertia xz, entry of the tensor [kg m²].
    XZ,
    /// Moment of inertia about y [kg m²].
    YY,
    /// Product of inertia yz, entry of the tensor [kg m²].
    YZ,
    /// Moment of inertia about z [kg m²].
    ZZ,
}

impl Inertial {
    /// All ten, in the order of a link's standard parameters.
    pub const ALL: [Inertial; 10] = {
        use Inertial::*;
        [M, MX, MY, MZ, XX, XY, XZ, YY, YZ, ZZ]
    };

    /// Symbol without a link's number.
    pub fn symbol(self) -> &'static str {
        ["M", "MX", "MY", "MZ", "XX", "XY", "XZ", "YY", "YZ", "ZZ"][self as usize]
    }

    /// Unit in the link frame.
    pub fn unit(self) -> &'static str {
        match self {
            Inertial::M => "kg",
            Inertial::MX | Inertial::MY | Inertial::MZ => "kg m",
            _ => "kg m^2",
        }
    }
}

/// Which of a link's standard parameters it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ParameterKind {
    /// Of the rigid body.
    Inertial(Inertial),
    /// `FV qd`
    Viscous,
    /// `FS sign(qd)`
    Coulomb,
}

/// One standard parameter: what it is and of which link (counted from 0).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Parameter {
    /// Number of the link, from 0.
    pub link: usize,
    /// Which of its parameters.
    pub kind: ParameterKind,
}

impl Parameter {
    /// Khalil's name with the link number from 1: `MY2`, `FS7`.
    pub fn name(&self) -> String {
        format!("{}{}", self.symbol(), self.link + 1)
    }

    /// Symbol without the link's number.
    pub fn symbol(&self) -> &'static str {
        match self.kind {
            ParameterKind::Inertial(i) => i.symbol(),
            ParameterKind::Viscous => "FV",
            ParameterKind::Coulomb => "FS",
        }
    }
}

/// The standard parameters of a robot, in order: per link `M MX MY MZ XX XY XZ YY YZ ZZ`, then `FV`, `FS` where the declared
/// model has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Layout {
    parameters: Vec<Parameter>,
    per_link: usize,
    revolute: Vec<bool>,
}

impl Layout {
    /// Standard parameters of `robot`: per link ten of the body, then declared friction.
    pub fn standard(robot: &Robot) -> Self {
        let mut kinds: Vec<_> = Inertial::ALL.map(ParameterKind::Inertial).to_vec();
        if robot.friction().viscous {
            kinds.push(ParameterKind::Viscous);
        }
        if robot.friction().coulomb {
            kinds.push(ParameterKind::Coulomb);
        }
        let parameters = (0..robot.joint_count())
            .flat_map(|link| kinds.iter().map(move |&kind| Parameter { link, kind }))
            .collect();
        let revolute = robot.joints().iter().map(|j| j.is_revolute()).collect();
        Self {
            parameters,
            per_link: kinds.len(),
            revolute,
        }
    }

    /// Number of standard parameters p.
    pub fn len(&self) -> usize {
        self.parameters.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.parameters.is_empty()
    }

    /// The parameters in order.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Parameters per link: 10, 11 or 12.
    pub fn per_link(&self) -> usize {
        self.per_link
    }

    /// Names in order, such as `MX3`.
    pub fn names(&self) -> Vec<String> {
        self.parameters.iter().map(Parameter::name).collect()
    }

    /// Position of an inertial parameter of `link` (from 0).
    pub fn inertial(&self, link: usize, which: Inertial) -> usize {
        link * self.per_link + which as usize
    }

    /// SI unit of parameter `index`; friction depends on whether the joint turns or slides.
    pub fn unit(&self, index: usize) -> &'static str {
        let parameter = self.parameters[index];
        match (parameter.kind, self.revolute[parameter.link]) {
            (ParameterKind::Inertial(i), _) => i.unit(),
            (ParameterKind::Viscous, true) => "N m s/rad",
            (ParameterKind::Viscous, false) => "N s/m",
            (ParameterKind::Coulomb, true) => "N m",
            (ParameterKind::Coulomb, false) => "N",
        }
    }

    /// The prior link parameters of the robot in this layout, where every link has them.
    pub fn prior(&self, robot: &Robot) -> Option<DVector<f64>> {
        let priors: Option<Vec<_>> = robot.joints().iter().map(|j| j.prior).collect();
        let priors = priors?;
        Some(DVector::from_iterator(
            self.len(),
            self.parameters.iter().map(|p| {
                let prior = &priors[p.link];
                match p.kind {
                    ParameterKind::Inertial(i) => prior.inertia.about_origin().parameters()[i as usize],
                    ParameterKind::Viscous => prior.viscous,
                    ParameterKind::Coulomb => prior.coulomb,
                }
            }),
        ))
    }

    /// Inertia of `link` in a parameter vector of this layout.
    pub fn link_inertia(&self, phi: &[f64], link: usize) -> LinkInertia {
        LinkInertia::from_parameters(&phi[link * self.per_link..link * self.per_link + 10])
    }
}
