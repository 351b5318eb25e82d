fn main() {
    let paths: Vec<std::path::PathBuf> = std::env::args_os().skip(1).map(Into::into).collect();
    let paths: Vec<&std::path::Path> = paths.iter().map(|p| p.as_path()).collect();
    let read = admire_rebuild::Record::read(&paths);
    for d in &read.diagnostics {
        println!("{:?}", d);
    }
    let r = read.value;
    let t = std::time::Instant::now();
    match admire_rebuild::mechanism(&r) {
        Ok(m) => {
            println!(
                "{:?} lever {:e} size {} down {:?}",
                t.elapsed(),
                m.lever_left,
                m.size,
                m.down
            );
            for x in &m.members {
                let b = |k: usize| &r.bodies[k].name;
                print!(
                    "{:60} I {:40} J {:40} open {:.1e} ",
                    r.elements[x.connection.element].name,
                    b(x.connection.i),
                    b(x.connection.j),
                    x.open
                );
                match &x.role {
                    admire_rebuild::Role::Joint(j) => println!("{} {:?}", j.kind, j.i.p.as_slice()),
                    admire_rebuild::Role::Carried => println!("carried"),
                    admire_rebuild::Role::Load(p) => println!("LOAD {:?}", p.as_slice()),
                    admire_rebuild::Role::Spring(s) => println!(
                        "SPRING {:?} {:?} {}",
                        s.i.as_slice(),
                        s.j.as_slice(),
                        format!("{:?}", s.law).chars().take(120).collect::<String>()
                    ),
                    admire_rebuild::Role::Motion { turns, .. } => println!("MOTION {turns}"),
                    admire_rebuild::Role::Bushing { i, j, law, .. } => {
                        println!(
                            "BUSHING {:?} {:?} {:?}",
                            i.p.as_slice(),
                            j.p.as_slice(),
                            law.coupled
                        );
                        for l in law.force.iter().chain(&law.torque) {
                            println!(
                                "        {}",
                                format!("{l:?}").chars().take(150).collect::<String>()
                            );
                        }
                    }
                }
            }
            for (k, b) in m.bodies.iter().enumerate() {
                println!(
                    "{:50} {:.9} {:?} open {:.1e}",
                    r.bodies[k].name,
                    b.mass,
                    b.centre.as_slice(),
                    b.open
                );
            }
            let n = |l: &Vec<usize>| {
                l.iter()
                    .map(|e| r.elements[*e].name.clone())
                    .collect::<Vec<_>>()
            };
            let deck = admire_rebuild::deck(&r, &m);
            std::fs::write("/tmp/model.adm", &deck.text).unwrap();
            std::fs::write("/tmp/states.acf", &deck.commands).unwrap();
            let t = std::time::Instant::now();
            let rep = admire_rebuild::repeat(&r, &deck);
            println!(
                "repeat {:?} {:?} worst {} err {:?}",
                t.elapsed(),
                rep.places
                    .iter()
                    .map(|p| p.map_or("-".into(), |p| format!("{p:.1e}")))
                    .collect::<Vec<_>>()
                    .join(" "),
                r.bodies[rep.worst].name,
                rep.error
            );
            println!(
                "rigid {:?}\nlost {:?}\nidle {:?}\nbare {:?}",
                m.rigid,
                n(&m.lost),
                n(&m.idle),
                m.bare
            );
        }
        Err(e) => println!("{e}"),
    }
}
