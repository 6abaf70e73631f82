#pragma once

#include "filter_pn_refine/creases/mouths.h"
#include "level.h"
#include "local_points.h"

/// What rings need seldom: where points crowd, and near creases.
namespace recon::pn
{

struct Workspace;

/// Keeps of too many hits those around: the four nearest in each of 24 sectors, also where a radius reaches across a
/// hole. Near creases only what lies on the centre's side. \returns how many are kept.
int choose_hits(const LocalPoints& points, const Centre& c, float least_crease_agreement, bool has_creases,
                const FaceSector& own_face, const std::vector<FaceSector>& faces, std::int32_t* hits, int count);

/// Finds Workspace::faces.
void find_faces(const Level& level, Workspace& w);

/// Candidates beyond the nearest edge of their face, as in the mouth of a bore, are none.
void reject_behind_edges(Workspace& w, const Centre& c);

/// Nor are those in mouths. \param spacing of the samples.
void reject_in_mouths(Workspace& w, const Centre& c, const Mouths& mouths, double spacing);

/// New points on the other side of a crease still keep others at a distance, but join nothing.
void reject_other_side(Workspace& w, const Centre& c, const FaceSector& own_face, float least_crease_agreement,
                       float least_distance);

} // namespace recon::pn
