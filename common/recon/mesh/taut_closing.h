#pragma once

#include <recon/geometry.h>

namespace recon
{

/// Draws a crust taut where it has no samples: over holes and open ends of a scan. There faces of the power diagram lie
/// between whatever large balls met and bulge, since no sample pays for them. Vertices farther than two spacings from
/// every sample move to the mean of their neighbours, the others held: Laplace's equation with mean value weights, a
/// membrane within the convex hull of its rim. Triangles stay what they are. Vertices of a triangle that is cut where
/// it was not, as where a hill rises through the membrane, are held nearer to where they were, and the others drawn
/// again; if cuts remain, nothing moves. \param mesh closed. \param samples in its units, may be none. \param threads
/// >= 1. \returns the number of vertices that moved.
int draw_bare_faces_taut(TriangleMesh& mesh, const Points& samples, int threads = 1);

} // namespace recon
