use super::ids::is_body;
use super::reader::Reader;
use super::settings::settings;
use super::{constraint, data, force, frame, friction};
use crate::model::{Model, PartIx};

/// Lowers one statement into the model: appends an object to the list of its kind, or changes settings. A marker that names no body is
/// placed on `body`.
pub(super) fn statement(reader: &mut Reader, body: Option<PartIx>, model: &mut Model) {
    match reader.def.name {
        "MARKER" => model.markers.extend(frame::marker(reader, body)),
        "JOINT" => model.joints.extend(constraint::joint(reader)),
        "JPRIM" => model.primitives.extend(constraint::primitive(reader)),
        "COUPLER" => model.couplers.extend(constraint::coupler(reader)),
        "GEAR" => model.gears.extend(constraint::gear(reader)),
        "FRICTION" => model.frictions.extend(friction::friction(reader)),
        "GCON" => model.gcons.extend(constraint::gcon(reader)),
        "MOTION" => model.motions.extend(constraint::motion(reader)),
        "BUSHING" => model.bushings.extend(force::bushing(reader)),
        "SPRINGDAMPER" => model.springdampers.extend(force::springdamper(reader)),
        "SFORCE" => model.sforces.extend(force::sforce(reader)),
        "GFORCE" | "VFORCE" | "VTORQUE" => model.vector_forces.extend(force::vector_force(reader)),
        "NFORCE" => model.nforces.extend(force::nforce(reader)),
        "VARIABLE" => model.variables.extend(data::variable(reader)),
        "DIFF" => model.diffs.extend(data::diff(reader)),
        "LSE" | "TFSISO" => model.linear_states.extend(data::linear_states(reader)),
        "ARRAY" => model.arrays.extend(data::array(reader)),
        "SPLINE" => model.splines.extend(data::spline(reader)),
        "STRING" => model.strings.extend(data::string(reader)),
        "SENSOR" => model.sensors.extend(data::sensor(reader)),
        "PINPUT" | "POUTPUT" | "PSTATE" => model.plant_ports.extend(data::plant_port(reader)),
        "REQUEST" => model.requests.extend(data::request(reader)),
        kind if force::is_pair_force(kind) => model.pair_forces.extend(force::pair_force(reader)),
        _ if is_body(reader.def) => model.parts.extend(frame::part(reader)),
        _ => settings(reader, model),
    }
}
