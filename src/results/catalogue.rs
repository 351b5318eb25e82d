/// One column of results.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize, serde::Deserialize)]
pub struct Component {
    /// Name inside its entity, for example `FX`.
    pub name: String,
    /// Unit as the file spells it, for example `newton-mm`; `None` for variables.
    pub units: Option<String>,
    /// Label for the axis of a plot; only some requests have one.
    pub plot_label: Option<String>,
    /// 1-based position of the value in every step.
    pub id: usize,
}

/// The results of one object of the model: one entity of the file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Entity {
    /// Name of the result set, for example `arm_XFORM`.
    pub name: String,
    /// Name of the object without the model name, for example `testrig.arm`.
    pub entity: Option<String>,
    /// Kind of the object, for example `Part`.
    pub ent_type: Option<String>,
    /// Id of the dataset statement of the object.
    pub object_id: Option<i64>,
    /// Comment of a request.
    pub comment: Option<String>,
    /// Columns.
    pub components: Vec<Component>,
}

impl Entity {
    /// Returns the component with this name; case is ignored.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components
            .iter()
            .find(|component| component.name.eq_ignore_ascii_case(name))
    }
}

/// The names of all result columns: the StepMap of an XRF file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Catalogue {
    /// Name of the map.
    pub name: String,
    /// Entities in the order of the file.
    pub entities: Vec<Entity>,
}

/// A component and the entity to which it belongs.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// Entity of the component.
    pub entity: &'a Entity,
    /// Component of the entity.
    pub component: &'a Component,
}

impl Catalogue {
    /// Creates a catalogue named `map_001`, as in ADAMS.
    pub fn new(entities: Vec<Entity>) -> Self {
        Self {
            name: "map_001".to_string(),
            entities,
        }
    }

    /// Returns the number of values in a step: the largest component id.
    pub fn len(&self) -> usize {
        self.columns().map(|c| c.component.id).max().unwrap_or(0)
    }

    /// Returns true if there are no components.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Iterates over all columns in the order of the file.
    pub fn columns(&self) -> impl Iterator<Item = Column<'_>> {
        self.entities.iter().flat_map(|entity| {
            entity
                .components
                .iter()
                .map(move |component| Column { entity, component })
        })
    }

    /// Returns the columns by position: element i has id i + 1, and a position without a column is `None`.
    pub fn by_position(&self) -> Vec<Option<Column<'_>>> {
        let mut columns = vec![None; self.len()];
        for column in self.columns() {
            if column.component.id > 0 {
                columns[column.component.id - 1] = Some(column);
            }
        }
        columns
    }

    /// Iterates over the entities whose result set or object has this name; case is ignored.
    pub fn entities_called<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Entity> {
        self.entities.iter().filter(move |entity| {
            entity.name.eq_ignore_ascii_case(name)
                || entity
                    .entity
                    .as_deref()
                    .is_some_and(|object| object.eq_ignore_ascii_case(name))
        })
    }

    /// Returns the entity of a statement, by kind (such as `Part`) and id.
    pub fn entity_of(&self, ent_type: &str, object_id: i64) -> Option<&Entity> {
        self.entities.iter().find(|entity| {
            entity.object_id == Some(object_id) && entity.ent_type.as_deref() == Some(ent_type)
        })
    }
}

impl Column<'_> {
    /// Returns `ENTITY.COMPONENT`, preceded by the owner of the object: `testrig.arm_XFORM.X`.
    ///
    /// Result sets of nested objects can share their short names; the owner makes the names unique.
    pub fn path(&self) -> String {
        let name = &self.entity.name;
        let component = &self.component.name;
        let full = self.entity.entity.as_deref();
        let owner = full.and_then(|full| full.rsplit_once('.'));
        match owner {
            // The name of a result set may already contain its owner: `Brake.Brake_Moment`.
            Some((owner, _)) if !is_in(name, owner) => format!("{owner}.{name}.{component}"),
            _ => format!("{name}.{component}"),
        }
    }
}

/// Returns true if the name begins with its owner's name and a dot.
fn is_in(name: &str, owner: &str) -> bool {
    let rest = name.strip_prefix(owner);
    rest.is_some_and(|rest| rest.starts_with('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_of_a_name_is_there_twice() {
        let component = Component {
            name: "X".to_string(),
            units: None,
            plot_label: None,
            id: 2,
        };
        for (name, full, path) in [
            ("arm_XFORM", "testrig.arm", "testrig.arm_XFORM.X"),
            (
                "Brake.Brake_Moment",
                "Brake.Brake_Moment",
                "Brake.Brake_Moment.X",
            ),
            ("Brake_Moment", "Brake.Brake_Moment", "Brake.Brake_Moment.X"),
            ("Brakes", "Brake.Brakes", "Brake.Brakes.X"),
            ("travel", "travel", "travel.X"),
        ] {
            let entity = Entity {
                name: name.to_string(),
                entity: Some(full.to_string()),
                ..Entity::default()
            };
            let column = Column {
                entity: &entity,
                component: &component,
            };
            assert_eq!(column.path(), path);
        }
    }
}
