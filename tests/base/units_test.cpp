#include "base/units.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

namespace dapple {
namespace {

double value(const char* text, Dimension dimension) {
    const Quantity quantity = parse_quantity(text, dimension);
    EXPECT_EQ(quantity.error, "") << text;
    return quantity.value;
}

std::string error(const char* text, Dimension dimension) {
    return parse_quantity(text, dimension).error;
}

TEST(Units, PlainNumbersAreSi) {
    for (const char* text : {"12", "12.", "12.0", "+12", "1.2e1", "120e-1", " 12 ", "1.2E+1"})
        EXPECT_EQ(value(text, Dimension::length), 12) << text;
    EXPECT_EQ(value(".5", Dimension::number), 0.5);
    EXPECT_EQ(value("-0.5", Dimension::number), -0.5);
    EXPECT_EQ(value("0", Dimension::length), 0);
    EXPECT_FALSE(parse_quantity("12", Dimension::length).has_unit);
    EXPECT_TRUE(parse_quantity("12 m", Dimension::length).has_unit);
}

TEST(Units, DecimalUnitsDoNotRound) {
    EXPECT_EQ(value("12.3 cm", Dimension::length), 0.123);
    EXPECT_EQ(value("0.1mm", Dimension::length), 0.0001);
    EXPECT_EQ(value("7 um", Dimension::length), 7e-6);
    EXPECT_EQ(value("1.1e3 km", Dimension::length), 1.1e6);
    EXPECT_EQ(value("35 %", Dimension::number), 0.35);
    EXPECT_EQ(value("70 ms", Dimension::time), 0.07);
    EXPECT_EQ(value("0.7 /cm", Dimension::per_length), 70);
    EXPECT_EQ(value("0.7 1/cm", Dimension::per_length), 70);
    EXPECT_EQ(value("1.1 kW/m2", Dimension::irradiance), 1100);
}

TEST(Units, AnglesAndSpeedsRoundOnce) {
    EXPECT_EQ(value("180 deg", Dimension::angle), std::numbers::pi);
    EXPECT_EQ(value("90 deg", Dimension::angle), std::numbers::pi / 2);
    EXPECT_EQ(value("53 deg", Dimension::angle), radians_from_degrees(53));
    EXPECT_EQ(value("36 km/h", Dimension::speed), 10);
    EXPECT_EQ(value("2 min", Dimension::time), 120);
}

TEST(Units, SpellingsOfOneUnit) {
    for (const char* text : {"3 W/m2", "3 W/m^2", "3 W / m²", "3W/m2"})
        EXPECT_EQ(value(text, Dimension::irradiance), 3) << text;
    EXPECT_EQ(value("3 W/m^2/sr", Dimension::radiance), 3);
}

TEST(Units, SaysWhatIsWrong) {
    EXPECT_EQ(error("30 deg", Dimension::length),
              "expected a length such as '12 cm' (um, mm, cm, m, km); '30 deg' is an angle");
    EXPECT_EQ(error("30 degs", Dimension::angle), "unknown unit 'degs'; did you mean 'deg'?");
    EXPECT_EQ(error("3 ft", Dimension::length), "unknown unit 'ft'; a length takes: um, mm, cm, m, km");
    EXPECT_EQ(error("far", Dimension::length), "expected a length such as '12 cm', got 'far'");
    EXPECT_EQ(error("", Dimension::length), "expected a length such as '12 cm', got ''");
    EXPECT_EQ(error("1e999", Dimension::number), "'1e999' is out of the range of numbers");
    EXPECT_EQ(error("1e99999999999999999999", Dimension::number),
              "'1e99999999999999999999' is out of the range of numbers");
    for (const char* text : {".nan", "nan", ".inf", "-.INF", "infinity"})
        EXPECT_EQ(error(text, Dimension::number), "'" + std::string(text) + "': a number must be finite");
    EXPECT_EQ(error("010", Dimension::number),
              "'010' starts with 0, which some readers take as octal; leave the 0 out");
    EXPECT_EQ(error("1_000", Dimension::number), "'1_000': write the number without '_'");
    EXPECT_EQ(error("1:30", Dimension::time), "'1:30': ':' is not part of a number; write a time as '90 s'");
    EXPECT_EQ(error("0,5", Dimension::number), "'0,5': write a decimal point, not a comma");
    EXPECT_EQ(error("0x10", Dimension::number), "'0x10' is no decimal number; write it in decimal digits");
    EXPECT_EQ(error("0o17", Dimension::number), "'0o17' is no decimal number; write it in decimal digits");
    for (const char* text : {"-", "+", ".", "e5", "--1"})
        EXPECT_NE(error(text, Dimension::number), "") << text;
    for (const char* text : {"1.2.3", "1e", "1 2", "5 m m/s"})
        EXPECT_NE(error(text, Dimension::length), "") << text;
}

TEST(Units, Integers) {
    EXPECT_EQ(parse_integer("-42").value, -42);
    EXPECT_EQ(parse_integer("+42").value, 42);
    EXPECT_EQ(parse_integer("9007199254740993").value, 9007199254740993);  // beyond what a double holds
    for (const char* text : {"1.0", "1e3", "12 m", "010", "0x10", "", "yes", "99999999999999999999"})
        EXPECT_NE(parse_integer(text).error, "") << text;
}

TEST(Units, FormatsForPeople) {
    EXPECT_EQ(format_quantity(radians_from_degrees(30), Dimension::angle), "30 deg");
    EXPECT_EQ(format_quantity(0.12, Dimension::length), "0.12 m");
    EXPECT_EQ(format_quantity(0.5, Dimension::number), "0.5");
}

}  // namespace
}  // namespace dapple
