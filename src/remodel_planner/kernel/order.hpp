// Lists of wires that follow a given order as far as the order constraints let them.
#pragma once

#include "problem.hpp"

namespace remodel {

// Write the wires in the order of their ranks (at least 0), the opening first; a wire whose
// predecessors come later by rank waits for them. Wires with modes that are not possible (such as -1) get the first
// end that suits the wire that follows, for two arms the arm preferred.
void follow_ranks(const Problem& problem, const int* rank, int* order, int* modes);

}  // namespace remodel
