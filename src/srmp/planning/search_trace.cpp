#include "srmp/planning/search_trace.hpp"

namespace srmp {

namespace {

thread_local SearchTrace* innermost = nullptr;

}  // namespace

TraceScope::TraceScope(SearchTrace& trace) : outer_(innermost) { innermost = &trace; }

TraceScope::~TraceScope() { innermost = outer_; }

SearchTrace* TraceScope::current() { return innermost; }

}  // namespace srmp
