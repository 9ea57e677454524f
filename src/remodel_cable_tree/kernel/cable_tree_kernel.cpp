// The kernel's functions for cable trees; cable_tree_planner.py declares the same.
#include <memory>

#include "cable_tree.hpp"
#include "cable_tree_search.hpp"

using remodel::CableTreeSearch;

namespace {

struct Session {
  explicit Session(const remodel::CableTreeTables& tables)
      : tree(tables), known(tables.ends), consistent(draw_conclusions(tree, known)) {}
  const remodel::CableTree tree;
  remodel::Precedence known;
  const bool consistent;
  std::unique_ptr<CableTreeSearch> search;
};

}  // namespace

extern "C" {

Session* remodel_cable_tree_new(const remodel::CableTreeTables* tables) {
  return new Session(*tables);
}

void remodel_cable_tree_delete(Session* session) { delete session; }

// Search an order that satisfies the constraints: 0 there is none, 1 found and written, 2 undecided.
std::int32_t remodel_cable_tree_find(Session* session, std::int64_t most_nodes,
                                     std::int32_t* order) {
  if (!session->consistent) return 0;
  return static_cast<std::int32_t>(
      remodel::find_order(session->tree, session->known, most_nodes, order));
}

// Write an order with many cables whose ends follow each other. False if none was found.
std::int32_t remodel_cable_tree_gather(Session* session, std::int64_t most_nodes,
                                       std::uint64_t seed, std::int32_t* order) {
  remodel::Random random(seed);
  return remodel::gather_cables(session->tree, session->known, most_nodes, random, order);
}

void remodel_cable_tree_adopt(Session* session, const std::int32_t* order, std::uint64_t seed) {
  session->search =
      std::make_unique<CableTreeSearch>(session->tree, session->known, order, seed);
}

// weights: of violated constraints, stored cables, open cables, the longest time, violated soft
// constraints.
std::int64_t remodel_cable_tree_anneal(Session* session, std::int64_t moves, double from, double to,
                                       const double* weights) {
  session->search->anneal(moves, from, to,
                          {weights[0], weights[1], weights[2], weights[3], weights[4]});
  return session->search->best_cost();
}

std::int64_t remodel_cable_tree_best(const Session* session, std::int32_t* order) {
  const std::vector<int>& best = session->search->best();
  std::copy(best.begin(), best.end(), order);
  return session->search->best_cost();
}

}  // extern "C"
