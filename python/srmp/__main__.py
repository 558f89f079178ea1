from srmp.cli import main

main()
