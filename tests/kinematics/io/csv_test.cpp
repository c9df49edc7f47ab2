#include "kinematics/io/csv.h"

#include <gtest/gtest.h>

namespace gelenk {
namespace {

using Fields = std::vector<std::string>;

TEST(Csv, FieldsOfAnyTextComeBack) {
  const Fields texts{"plain", "", "a,b", "say \"hi\"", "two\nlines", " blank ", "\"", "r\r"};
  const std::string line = csvLine(texts);
  CsvReader reader(line);
  Fields found;
  ASSERT_TRUE(reader.next(found));
  EXPECT_EQ(found, texts);
  EXPECT_TRUE(reader.complete());
  EXPECT_FALSE(reader.next(found));
  EXPECT_EQ(csvField("a,b"), "\"a,b\"");
  EXPECT_EQ(csvField("a\"b"), "\"a\"\"b\"");
}

TEST(Csv, RecordsKnowTheirLineAndWhetherTheyWereCutOff) {
  CsvReader reader("a,b\r\n\"x\ny\",2\n3,");
  Fields found;
  ASSERT_TRUE(reader.next(found));
  EXPECT_EQ(found, (Fields{"a", "b"}));
  ASSERT_TRUE(reader.next(found));
  EXPECT_EQ(found, (Fields{"x\ny", "2"}));
  EXPECT_EQ(reader.line(), 2);
  EXPECT_EQ(reader.record(), "\"x\ny\",2\n");
  ASSERT_TRUE(reader.next(found));
  EXPECT_EQ(found, (Fields{"3", ""}));
  EXPECT_EQ(reader.line(), 4);
  EXPECT_FALSE(reader.complete());
}

}  // namespace
}  // namespace gelenk
