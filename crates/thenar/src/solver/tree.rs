//! The order of jointed bodies: leaves first, or, read backwards, roots first.

/// A bone and the joint that ties it to the rest of its tree.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// The bone.
    pub bone: usize,
    /// Its joint; `None` at the root of a tree that floats.
    pub joint: Option<usize>,
    /// The bone on the other side, when that one moves.
    pub parent: Option<usize>,
    /// The joint's own parent is this link's child side.
    pub reversed: bool,
}

/// Children before parents; `None` when a loop is closed, also through bodies that do not move.
pub fn leaves_first(moves: &[bool], ends: &[(Option<u32>, u32)]) -> Option<Vec<Link>> {
    let mobile = |b: Option<u32>| b.map(|b| b as usize).filter(|&b| moves[b]);
    // Joints to the world or to a prescribed body make their bone the root of its tree.
    let mut anchor: Vec<Option<(usize, bool)>> = vec![None; moves.len()];
    let mut neighbours: Vec<Vec<(usize, usize, bool)>> = vec![Vec::new(); moves.len()];
    for (j, &(parent, child)) in ends.iter().enumerate() {
        match (mobile(parent), mobile(Some(child))) {
            (Some(p), Some(c)) => {
                neighbours[p].push((c, j, false));
                neighbours[c].push((p, j, true));
            }
            (Some(b), None) | (None, Some(b)) => {
                let reversed = mobile(parent).is_some();
                if anchor[b].replace((j, reversed)).is_some() {
                    return None;
                }
            }
            (None, None) => {}
        }
    }

    let mut visited: Vec<bool> = moves.iter().map(|&m| !m).collect();
    let mut links = Vec::new();
    let roots = (0..moves.len())
        .filter(|&b| anchor[b].is_some())
        .chain((0..moves.len()).filter(|&b| anchor[b].is_none()));
    for root in roots {
        if visited[root] {
            // An anchored bone reached from another anchored one closes a loop.
            if anchor[root].is_some() {
                return None;
            }
            continue;
        }
        visited[root] = true;
        let (joint, reversed) = anchor[root].unzip();
        let first = links.len();
        links.push(Link { bone: root, joint, parent: None, reversed: reversed.unwrap_or(false) });
        let mut next = first;
        while next < links.len() {
            let from: Link = links[next];
            for &(to, j, reversed) in &neighbours[from.bone] {
                if next != first && from.joint == Some(j) {
                    continue;
                }
                if visited[to] {
                    return None;
                }
                visited[to] = true;
                links.push(Link { bone: to, joint: Some(j), parent: Some(from.bone), reversed });
            }
            next += 1;
        }
    }
    links.reverse();
    Some(links)
}
