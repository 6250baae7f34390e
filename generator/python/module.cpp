// The extension `ensonify._core`. Its documentation is the stub _core.pyi in the package.
#include <pybind11/functional.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <condition_variable>
#include <thread>

#include "ping/sequence_info.h"
#include "ping/tables.h"
#include "python/scenario.h"
#include "python/values.h"
#include "run/program.h"
#include "run/runs.h"

namespace ensonify::python {
namespace py = pybind11;
namespace {

using Unlocked = py::call_guard<py::gil_scoped_release>;

template <class T>
T& value_of(Result<T>& result) {
  if (!result) {
    const py::gil_scoped_acquire locked;
    raise(result.error());
  }
  return *result;
}

std::shared_ptr<CheckedScenario> open_scenario(
    std::string text, const std::string& label,
    const std::vector<std::pair<std::string, std::string>>& overrides, bool on_device) {
  ScenarioOptions input{label, {}, std::move(text)};
  for (const auto& [path, value] : overrides) input.overrides.push_back({path, value});
  auto opened = CheckedScenario::open(std::move(input),
                                      on_device ? BackendChoice::automatic : BackendChoice::cpu);
  return value_of(opened);
}

// Returns a ping, the message of a sequence that cannot be made, or None at the end.
py::object next_of(PingStream& stream) {
  std::optional<Result<StreamedPing>> next;
  {
    const py::gil_scoped_release unlocked;
    next = stream.next();
  }
  if (!next) return py::none();
  if (*next) return py::cast(std::make_shared<StreamedPing>(std::move(**next)));
  const Error& error = next->error();
  if (error.kind != ErrorKind::usage) raise(error);
  return py::str(error.message);
}

// A data set that a separate thread writes.
class Generation {
 public:
  Generation(const CheckedScenario& scenario, const std::string& folder,
             std::optional<PingRange> sequences, int threads, bool overwrite) {
    if (const Status claimed = claim_process(); !claimed) raise(claimed.error());
    options_.input = scenario.input();
    options_.output = folder;
    options_.sequences = sequences;
    options_.threads = threads;
    options_.overwrite = overwrite;
    options_.quiet = true;
    options_.hooks = &hooks_;
    hooks_ = {[this](std::string_view text) { add_warning(text); },
              [this](std::uint64_t done, std::uint64_t all) { set_progress(done, all); },
              &stopped_};
    thread_ = std::thread([this] { run(); });
  }

  ~Generation() {
    stopped_ = true;
    const py::gil_scoped_release unlocked;
    if (thread_.joinable()) thread_.join();
  }

  bool wait(int milliseconds) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::milliseconds(milliseconds), [&] { return done_; });
  }

  void stop() { stopped_ = true; }

  std::pair<std::uint64_t, std::uint64_t> progress() {
    const std::lock_guard lock(mutex_);
    return {made_, all_};
  }

  std::vector<std::string> warnings() {
    const std::lock_guard lock(mutex_);
    return warnings_;
  }

  void check() const {
    if (thrown_) std::rethrow_exception(thrown_);
    if (!status_) raise(status_.error());
  }

 private:
  void run() {
    try {
      status_ = generate(options_);
    } catch (...) {
      thrown_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  void add_warning(std::string_view text) {
    const std::lock_guard lock(mutex_);
    warnings_.emplace_back(text);
  }

  void set_progress(std::uint64_t done, std::uint64_t all) {
    const std::lock_guard lock(mutex_);
    made_ = std::max(made_, done);
    all_ = all;
  }

  GenerateOptions options_;
  RunHooks hooks_;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t made_ = 0, all_ = 0;
  std::vector<std::string> warnings_;
  bool done_ = false;
  Status status_;
  std::exception_ptr thrown_;
  std::thread thread_;
};

void bind_streams(py::module_& module) {
  py::class_<LaneRequest>(module, "LaneRequest")
      .def(py::init<>())
      .def_readwrite("listed", &LaneRequest::listed)
      .def_readwrite("start", &LaneRequest::start)
      .def_readwrite("stop", &LaneRequest::stop)
      .def_readwrite("step", &LaneRequest::step)
      .def_readwrite("skipped", &LaneRequest::skipped);
  py::class_<StreamRequest>(module, "StreamRequest")
      .def(py::init<>())
      .def_readwrite("lanes", &StreamRequest::lanes)
      .def_readwrite("turn", &StreamRequest::turn)
      .def_readwrite("split", &StreamRequest::split)
      .def_readwrite("flags", &StreamRequest::flags)
      .def_readwrite("pings", &StreamRequest::pings)
      .def_readwrite("threads", &StreamRequest::threads)
      .def_readwrite("threads_within", &StreamRequest::threads_within)
      .def_readwrite("ahead", &StreamRequest::ahead);
  py::class_<PingStream, std::shared_ptr<PingStream>>(module, "Stream")
      .def(
          "wait",
          [](PingStream& stream, int milliseconds) {
            return stream.wait(std::chrono::milliseconds(milliseconds));
          },
          py::arg("milliseconds"), Unlocked())
      .def_property_readonly("ready", &PingStream::ready)
      .def_property_readonly("is_resting", &PingStream::is_resting)
      .def("next", &next_of);
  py::class_<Generation>(module, "Generation")
      .def(py::init<const CheckedScenario&, const std::string&, std::optional<PingRange>, int,
                    bool>(),
           py::arg("scenario"), py::arg("folder"), py::arg("sequences"), py::arg("threads"),
           py::arg("overwrite"))
      .def("wait", &Generation::wait, py::arg("milliseconds"), Unlocked())
      .def("stop", &Generation::stop)
      .def("progress", &Generation::progress)
      .def("warnings", &Generation::warnings)
      .def("check", &Generation::check);
}

void bind_scenario(py::module_& module) {
  py::class_<CheckedScenario, std::shared_ptr<CheckedScenario>>(module, "Scenario")
      .def(py::init(&open_scenario), py::arg("text"), py::arg("label"), py::arg("overrides"),
           py::arg("on_device"))
      .def_property_readonly("name", [](const CheckedScenario& s) { return s.first().name; })
      .def_property_readonly("seed", [](const CheckedScenario& s) { return s.first().seed; })
      .def_property_readonly("sequences",
                             [](const CheckedScenario& s) { return s.first().sequences; })
      .def_property_readonly("classes",
                             [](const CheckedScenario& s) { return s.first().class_names; })
      .def_property_readonly("class_kinds",
                             [](const CheckedScenario& s) {
                               std::vector<std::string> kinds;
                               for (const ClassKind kind : s.first().class_kinds) {
                                 kinds.emplace_back(name_of(kind));
                               }
                               return kinds;
                             })
      .def_property_readonly(
          "flags", [](const CheckedScenario& s) { return flags_of(s.first().output.selection); })
      .def("split",
           [](const CheckedScenario& s, std::uint32_t sequence) {
             return pick_split(s.first().splits, s.first().seed, sequence);
           })
      .def("sample",
           [](CheckedScenario& s, std::uint32_t sequence) {
             Result<std::string> text = [&] {
               const py::gil_scoped_release unlocked;
               return s.sample(sequence);
             }();
             return dict_of(value_of(text));
           })
      .def(
          "pings_of",
          [](CheckedScenario& s, std::uint32_t sequence) {
            auto pings = s.pings_of(sequence);
            return value_of(pings);
          },
          Unlocked())
      .def("new_warnings", &CheckedScenario::new_warnings)
      .def(
          "stream",
          [](const std::shared_ptr<CheckedScenario>& s, const StreamRequest& request) {
            auto stream = stream_of(s, request);
            return value_of(stream);
          },
          Unlocked());
}

}  // namespace
}  // namespace ensonify::python

PYBIND11_MODULE(_core, module) {
  using namespace ensonify::python;
  module.attr("__version__") = ensonify::program_version();
  bind_scenario(module);
  bind_ping(module);
  bind_streams(module);
}
