#include "tools/bench/general_solver.h"

#include <dlfcn.h>

#include <cstdint>
#include <ctime>
#include <type_traits>

#include "base/check.h"

namespace muster::tools {
namespace {

/// CBC's C interface (coin/Cbc_C_Interface.h, version 2.10), as far as it is used here.
struct Interface {
  using Model = void;
  Model* (*new_model)();
  void (*delete_model)(Model*);
  void (*set_log_level)(Model*, int);
  void (*load_problem)(Model*, int columns, int rows, const int* start, const int* index,
                       const double* value, const double* column_low, const double* column_high,
                       const double* objective, const double* row_low, const double* row_high);
  void (*set_sense)(Model*, double);
  void (*set_integer)(Model*, int);
  void (*set_gap)(Model*, double);
  void (*set_fraction_gap)(Model*, double);
  void (*set_seconds)(Model*, double);
  int (*solve)(Model*);
  int (*is_optimal)(Model*);
  double (*value)(Model*);
};

class Cbc : public GeneralSolver {
 public:
  Cbc(void* library, const Interface& cbc) : library_(library), cbc_(cbc) {}
  ~Cbc() override { dlclose(library_); }

  Answer Heaviest(const std::vector<scheduler::Node>& nodes, const scheduler::Elements& elements,
                  bool shares, double seconds) override {
    std::vector<int> start = {0}, row;
    std::vector<double> weight;
    for (const scheduler::Node& node : nodes) {
      for (const std::int32_t e : ElementsOf(node, elements)) row.push_back(e);
      start.push_back(static_cast<int>(row.size()));
      weight.push_back(node.weight);
    }
    const std::vector<double> ones(row.size(), 1), low(nodes.size(), 0), high(nodes.size(), 1);
    const std::vector<double> row_low(elements.capacity.size(), -1e30);
    const std::vector<double> row_high(elements.capacity.begin(), elements.capacity.end());
    Interface::Model* model = cbc_.new_model();
    cbc_.set_log_level(model, 0);
    cbc_.load_problem(model, static_cast<int>(nodes.size()), static_cast<int>(row_high.size()),
                      start.data(), row.data(), ones.data(), low.data(), high.data(), weight.data(),
                      row_low.data(), row_high.data());
    cbc_.set_sense(model, -1);
    for (std::size_t c = 0; !shares && c < nodes.size(); ++c) {
      cbc_.set_integer(model, static_cast<int>(c));
    }
    cbc_.set_gap(model, 1e-9);
    cbc_.set_fraction_gap(model, 0);
    cbc_.set_seconds(model, seconds);
    Answer answer;
    const double before = CpuSeconds();
    cbc_.solve(model);
    answer.cpu_s = CpuSeconds() - before;
    if (cbc_.is_optimal(model)) answer.weight = cbc_.value(model);
    cbc_.delete_model(model);
    return answer;
  }

 private:
  void* library_;
  Interface cbc_;
};

}  // namespace

std::unique_ptr<GeneralSolver> GeneralSolver::Load() {
  void* library = dlopen("libCbcSolver.so.3", RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return nullptr;
  bool whole = true;
  const auto find = [&](const char* name, auto* function) {
    *function = reinterpret_cast<std::remove_pointer_t<decltype(function)>>(dlsym(library, name));
    whole = whole && *function != nullptr;
  };
  Interface cbc{};
  find("Cbc_newModel", &cbc.new_model);
  find("Cbc_deleteModel", &cbc.delete_model);
  find("Cbc_setLogLevel", &cbc.set_log_level);
  find("Cbc_loadProblem", &cbc.load_problem);
  find("Cbc_setObjSense", &cbc.set_sense);
  find("Cbc_setInteger", &cbc.set_integer);
  find("Cbc_setAllowableGap", &cbc.set_gap);
  find("Cbc_setAllowableFractionGap", &cbc.set_fraction_gap);
  find("Cbc_setMaximumSeconds", &cbc.set_seconds);
  find("Cbc_solve", &cbc.solve);
  find("Cbc_isProvenOptimal", &cbc.is_optimal);
  find("Cbc_getObjValue", &cbc.value);
  if (!whole) {
    dlclose(library);
    return nullptr;
  }
  return std::make_unique<Cbc>(library, cbc);
}

double CpuSeconds() {
  std::timespec now{};
  MUSTER_CHECK(clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now) == 0);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace muster::tools
