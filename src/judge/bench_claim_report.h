#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "judge/bench_claims.h"
#include "report/html_page.h"

/// What a bench says of claims: the parts of its report.
namespace dapple::judge {

std::string claims_text(const std::vector<ClaimResult>& claims);
std::string claims_csv(const std::vector<ClaimResult>& claims);
nlohmann::ordered_json claims_json(const std::vector<ClaimResult>& claims);
void add_claims(report::HtmlPage& page, const std::vector<ClaimResult>& claims);

/// The rows that left what is expected, and those without a figure: "CLAIM: ROW: why".
std::vector<std::string> claim_failures(const std::vector<ClaimResult>& claims);

}  // namespace dapple::judge
