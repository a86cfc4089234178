#pragma once
#include <cstdint>
#include <string>

namespace dapple::run {

/// "8G", "512 MiB", "2.5g" or bytes; K, M, G and T are powers of 1024. Throws Error(usage).
std::uint64_t parse_bytes(const std::string& text);

/// "3.2 GiB".
std::string format_bytes(double bytes);

/// Three quarters of what the process may use: physical memory, or the limit of its control group where that
/// is lower. The rest is left to the system and its file cache.
std::uint64_t default_memory_budget();

}  // namespace dapple::run
