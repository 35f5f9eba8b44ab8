//! Identities that hold for every serial arm, tried on random ones.

#[path = "../support/mesh.rs"]
mod mesh;
#[path = "../support/mod.rs"]
mod support;

mod dynamics;
mod excitation;
mod meshes;
mod mjcf_meshes;
mod requests;
mod robot_files;
mod robots;
mod shapes;
mod space;
mod trajectory;
mod trajectory_files;
