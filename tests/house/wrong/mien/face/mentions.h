#pragma once

// Wrong mentions, for the test of the test: the check over pages must refuse each, and no other. Right is
// docs/page.md, "A heading".
// There is no docs/No-page2.md; nor does the page have what is mentioned next: docs/page.md,
// "Another heading". Pages have no numbers either: docs/page.md, section 4.
