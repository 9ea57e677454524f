// Lists of wires that follow a given order as far as the order constraints let them.
#pragma once

#include "problem.hpp"

namespace remodel {

// Write the wires in the order of their ranks (at least 0); a wire whose predecessors come later by
// rank waits for them. The opening comes first, unless it need not and `opening_first` is false:
// then an older order is kept as it is. Wires with modes that are not possible (such as -1) get the
// arm preferred; with one arm, all get the first end that suits the wire that follows.
void follow_ranks(const Problem& problem, const int* rank, bool opening_first, int* order,
                  int* modes);

}  // namespace remodel
