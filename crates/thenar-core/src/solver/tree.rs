//! The order of jointed bodies: leaves first, or, read backwards, roots first.

/// A bone and the joint that ties it to the rest of its tree.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// The bone.
    pub bone: usize,
    /// Joint of the bone; `None` at the root of a tree that floats.
    pub joint: Option<usize>,
    /// The bone on the other side, when that one moves.
    pub parent: Option<usize>,
    /// The joint's own parent is this link's child side.
    pub reversed: bool,
}

/// Jointed bodies as trees, and the joints left over because they close loops.
#[derive(Clone, Debug)]
pub struct Spanning {
    /// Roots first.
    pub links: Vec<Link>,
    /// The joints that close loops, also through bodies that do not move.
    pub cuts: Vec<usize>,
}

/// Children before parents; `None` when a loop is closed, also through bodies that do not move.
pub fn leaves_first(moves: &[bool], ends: &[(Option<u32>, u32)]) -> Option<Vec<Link>> {
    let Spanning { mut links, cuts } = spanning(moves, ends);
    links.reverse();
    cuts.is_empty().then_some(links)
}

/// Trees that reach every body that moves; those tied to the world or to a prescribed body hang
/// from there.
pub fn spanning(moves: &[bool], ends: &[(Option<u32>, u32)]) -> Spanning {
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
            (Some(b), None) | (None, Some(b)) if anchor[b].is_none() => {
                anchor[b] = Some((j, mobile(parent).is_some()));
            }
            _ => {}
        }
    }

    let mut visited: Vec<bool> = moves.iter().map(|&m| !m).collect();
    let mut spans = vec![false; ends.len()];
    let mut links: Vec<Link> = Vec::new();
    let roots = (0..moves.len())
        .filter(|&b| anchor[b].is_some())
        .chain((0..moves.len()).filter(|&b| anchor[b].is_none()));
    for root in roots {
        if std::mem::replace(&mut visited[root], true) {
            continue;
        }
        let (joint, reversed) = anchor[root].unzip();
        let mut next = links.len();
        links.push(Link { bone: root, joint, parent: None, reversed: reversed.unwrap_or(false) });
        joint.into_iter().for_each(|j| spans[j] = true);
        while next < links.len() {
            let bone = links[next].bone;
            for &(to, j, reversed) in &neighbours[bone] {
                if !std::mem::replace(&mut visited[to], true) {
                    spans[j] = true;
                    links.push(Link { bone: to, joint: Some(j), parent: Some(bone), reversed });
                }
            }
            next += 1;
        }
    }
    let tied = |j: &usize| mobile(ends[*j].0).or(mobile(Some(ends[*j].1))).is_some();
    let cuts = (0..ends.len()).filter(|&j| !spans[j]).filter(tied).collect();
    Spanning { links, cuts }
}
