"""What every study's page is made of, as Markdown and as HTML."""
